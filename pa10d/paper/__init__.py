"""The procedure of Vuong & Ang (2009), step by step, as functions on arrays and recordings.

boundary   from which speed on is friction linear? (2.2, eq. 6-7, Table 1)
periods    averaging over periods, Fourier fit of the motion, cut-off (2.3, eq. 15)
variants   estimates from fast samples and from all, free and feasible (2.2-2.4, eq. 8-12, 16-17)
"""
