"""What the paper measured on its PA10, joints 1-4: what our own figures stand beside.

Its figures are not in the text, and the row labels of its Table 2 are garbled; these are its tables
1 and 3 and the numbers that it states (Vuong & Ang 2009, section 3).
"""

from __future__ import annotations

BOUNDARY_VELOCITY = (0.25, 0.27, 0.3, 0.6)  # rad/s, Table 1
CONDITION_NUMBER = 65.0  # "around 65", 3.1 step 3
SHARE_OF_SET_A = 0.3  # of the samples of set B, 3.2.1
RMS_SET_A = (4.1, 5.9, 1.5, 3.7)  # N·m, Table 3
RMS_SET_B = (3.9, 7.1, 2.1, 5.8)  # N·m, Table 3
LUMPED_PARAMETERS = 18  # for seven joints, 2.2; the rank gives 43, and 22 for the first four
