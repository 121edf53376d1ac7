"""Every number that the diagnosis was given, and where each comes from.

Five origins, in this order: *statistics* (a level, or what follows from one), *physics and
arithmetic* (units, filters, rounding, what a sensor can tell), *effort* (how much is tried: more
costs time and finds no less), *policy* (what is worth a word), and *chosen*: settled while looking
at data, which is named where it is known. A chosen number is the one to distrust on a machine
unlike those; how much hangs on it stands beside it where it was measured.
"""

from __future__ import annotations

import numpy as np

from pa10d.judgement import MATERIAL

# -- statistics ------------------------------------------------------------------------------------

SEARCH_LEVEL = 0.01  # false alarms over a whole search (fixed from outside: at most 1 %)
MAP_LEVEL = 0.01  # of structure that no effect explains: the same promise
SMOOTH_LEVEL = 0.01  # of a map that a user chose
TELL_APART = 2.6  # standard errors by which the better of two rivals must lead: 1 %, two-sided
HELD_OUT_LEVEL = 0.05  # of one candidate on the held-out side alone; both sides make SEARCH_LEVEL
COMES_AGAIN_LEVEL = 1e-3  # of a whole diagnosis, that an error comes again
BEYOND_NOISE_LEVEL = 1e-3  # of a whole diagnosis, that a noise floor is that much too low
FORETOLD_LEVEL = 1e-3  # of a whole diagnosis: at 1 % one clean two-link arm of 60 was claimed
COMMON_LEVEL = FORETOLD_LEVEL  # of a whole diagnosis, that errors of several joints go together
LEAST_FREE = 3.0  # samples as good as independent, beyond two, below which nothing agrees surely
CONTRADICTED_LEVEL = 1e-3  # of a whole diagnosis, that fitted runs contradict each other
GEOMETRY_LEVEL = 1e-3  # of a whole diagnosis, that lengths or axes are not as the URDF says
STEP_LEVEL = 1e-3  # of a whole diagnosis, that a joint changes at one moment of its runs
FRICTION_LEVEL = 1e-3  # of a whole diagnosis, that friction held out is other than fitted
HUBER = 1.345  # standard deviations at which its weights begin to fall: 95 % efficient
BIWEIGHT = 4.685  # standard deviations beyond which Tukey's are zero: 95 % efficient
SIZED_LEVEL = 0.05  # of coefficients that may as well be zero by their own errors
CHOSEN = 1e-9  # of its range: how well an exponent is known that is taken as it was found
AT_RANDOM = 0.05  # p from which on an error is said not to come again
TIMING_SIGNIFICANT = 3.0  # standard errors of a common timing offset
HARM_SIGNIFICANT = 3.0  # standard errors by which a joint's error must have risen
WORTH_AN_EXPERIMENT = 3.0  # standard errors by which it must be expected to tell two rivals apart
LOOSE = 2.0  # standard errors of a corner's speed that reach down to zero: it may as well be sharp
CORNER_ERRORS = (-2.0, -1.0, 1.0, 2.0)  # at which a corner may as well be (95 %)
CORNERS = 2.0 ** np.arange(-4.0, 5.0)  # times its speed, where a loose corner is looked for
LEAST_GAIN = 12.0  # units of noise: χ² of one degree at 5·10⁻⁴, 1 % over twenty suspects
SHORTLIST = 12  # candidates that a term already in the model is taken to have been judged among
FEWEST_TO_JUDGE = 12  # independent samples of a joint: its variance is known to 40 %
PER_UNKNOWN = 2.0  # independent samples per unknown, least number of a fit
WORTH_A_STEP = 0.1  # squared standard errors of the noise: less moves no estimate visibly

# -- physics and arithmetic ------------------------------------------------------------------------

SWING_SAMPLES = 16.0  # per period of the equation's cut-off, of a motion that is integrated
THIN_BAND = 0.35  # of the rate of such a motion is kept: five times the cut-off and more
THIN_ORDER = 8  # so that the band of the equation passes whole, and next to nothing folds into it
PASSED_MOTION = 0.995  # of the velocity's power lies below the highest frequency of a motion
GUARD_PERIODS = 1.5  # of the cut-off, left out where blocks meet: the filter looks that far
LOWEST_ORDER = 4.0  # cycles per revolution: below, gravity and ripple cannot be told apart
RIPPLE_LEAST_SPAN = 1e-3  # rad: a joint that turned less has no orders
TIMING_MOST_SAMPLES = 3.0  # raw periods: the model brought its own offset, this is a correction
FORETOLD_LATE = (0.2, 0.6)  # s ago: speeds that a filter of the residual cannot have seen
ALIKE = 2.0  # samples that say the same to begin with: the equation keeps twice as many as needed
MAP_THIN = 2  # rows left out between, for the same reason
FORETOLD_THIN = 2  # likewise
MAJORITY_THIN = 2  # likewise
ABSORBED = 1e-4  # share of a column's power below which the model absorbs it: not identifiable
ROUNDED = 1e-8  # the same of what rounding takes: differences of squares in sixteen digits
BLURRED_LEAST = 0.1  # of what is left of a joint: what is off by that weighs a hundredth of it
LEAST_OWN = 0.01  # of the power of what an effect changes held out: its own torque's (policy)
SLOPE_STEP = 1e-3  # of the value, or, on a linear scale, of the search's first step if more
CHANNEL_STEP = 0.05  # of a channel's time, over which it is as good as linear in that
STIFFNESS_ROUNDING = 1e-9  # of the target's squares: less is never left over
STEP_MARGIN = 1.0  # s of a run before a step and after it, to know what it was and is
PLAN_RATE = 100.0  # Hz: enough for the sizes of torques
LONGEST_PLAN = 180.0  # s: more is no experiment but a day's work

# -- effort ----------------------------------------------------------------------------------------

STEPS_PER_JOINT = 3  # effects that one search adds at most: friction alone may be two of a joint
LEAST_STEPS = 8  # of few joints
PER_JOINT = 4  # candidates of one step and joint that are judged on the held-out side
SHARED_PAIRS = 2  # effects that show in shared bodies beside which a second one is looked for
SEARCH_THREADS = 2
TOGETHER = 12  # shapes whose columns are made, filtered and judged at once
CLOSER_LOOKS = 2  # starts of an effect whose gain is rough in its shape, looked around once more
CLOSER_STEPS = (1.0, 0.25)  # parts of a step of those looks, each time they are settled again
START_THIN = 10  # samples of which one is looked at for where a shape may start
LINES_WORK = 1e9  # products of samples and orders of a spectrum against angle: some seconds
ORDERS_PER_RESOLUTION = 3  # looked at per order that the recording can tell apart
BRISTLE_ROUNDS = 4  # in which a joint's bristles and what they carry draw each other on
MORE_ROUNDS = 8  # of settling, beyond the usual
AS_BEFORE = 0.0025  # of what a fit leaves: a round of loads that changes less changes nothing
HOME_ROUNDS = 12  # in which the secant of a law becomes that of its own answer
OWN_LEVEL = 0.01  # χ² of a frozen model's coefficients: so seldom it would be off by as much itself
OWN_ROUNDS, OWN_STEP = 6, 1.05  # in which it is held back to that, each a little farther than asked
AT_HOME = 0.05  # standard errors of the noise: what a round moves less is there
SPRINGS_FOLLOWED = 2  # joints whose springs are sought together with the bodies, of all guesses
SPRING_NEARLY = 0.5  # of what the best guess promises: one that promises as much is followed, too,
#   where those leave more than noise; a guess may be off by as much
SPRING_STEPS = (3, 20)  # of Gauss and Newton's, from each start and from the best of them
SPRING_STEP = 1.0  # of a logarithm of stiffness or damping, at most
ROTOR_STEP = 0.3  # of the link's inertia, at most, that goes over to its rotor in such a step: at
#   0.7 one start of three ends where all of the inertia is rotor
SPRING_WORTH = 1e-3  # drop of the errors' logarithms, summed over the joints, of a step
SPRING_ONE = 0.1  # by which stiffnesses differ that a few steps from other bodies come to, if they
# are one: at most
SPRING_HOLDS = 2.0  # times as stiff, where a link would run away
PASSED_SAMPLES = 400  # of a run, that say where a spring may be
PASSED_ROUNDS = 2  # in which friction and bodies settle behind a spring
PASSED_MODES = (0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0)  # of a link, over the motion's highest
#   frequency, from which springs are sought
SWUNG_MODES = (1.4, 2.0, 2.8, 4.0, 5.6, 8.0)  # the same of a link that swings by itself, below
#   the cut-off
FIRM_MODES = (0.6, 1.2)  # of the cut-off: of links that nothing but reversals and the beginning
#   sets swinging; from half to twice a mode is near enough
FIRM_ZETA = 0.2  # from which those are sought: a wide peak is found from farther away
FIRM_ROTOR = 0.5  # of the inertia of rotor and link, likewise
STEP_EVERY, STEP_CLOSELY = 0.5, 0.05  # s between moments that are tried, and around the best
PICKED_MOMENTS = 20  # of each run, at which an arm may have picked up something, before the best is
#   sought more closely
COMING_ON = (0.03, 0.1, 0.3, 1.0, 10.0)  # of a run, that what comes on slowly may take
STEP_SHARES = (1.0, 0.5, 0.2)  # of a Gauss-Newton step, tried in turn
STEP_DAMPINGS = (0.0, 0.02, 0.1, 0.4, 2.0, 10.0)  # of one beside springs, likewise: shares of
#   a column's length, from next to what the data show least of to each parameter on its own
MAJORITY_ROUNDS = (4, 12)  # Huber's weights find the neighbourhood, Tukey's forget the rest
TIMING_ROUNDS = 3
DEAD_BAND_ROUNDS = 12  # in which friction that a dead band hid comes back, and the band with it
BLURRED_ROUNDS = 3  # in which what is left clear of knocks says what is clear of them
SMOOTH_ROUNDS = 2
MAPS_PER_JOINT = 3  # that are judged held out
FORETOLD_TRIED = 2  # sets of quantities per joint that are judged held out
FORETOLD_FOLDS = 4  # stretches of the fit side that take turns in settling set and ridge
COMMON_MOMENTS = {"sway": (0.1, 0.25, 0.5, 1.0, 2.0), "stamps": (0.02, 0.04, 0.08)}
# s for which a cause in common is as large; tried: a base or a load that sways, stamps that scatter
COMMON_RIDGES = (1e-3, 1e-2, 1e-1, 1.0)  # of the mean square of its columns
FORETOLD_DEGREE = 3  # of products of quantities
FORETOLD_WAVES = 150  # random Fourier features beside them (Rahimi & Recht 2007)
FORETOLD_WIDTHS = (0.5, 1.0, 2.0)  # standard deviations of a quantity in which they turn by 1 rad
FORETOLD_RIDGES = 10.0 ** np.arange(-3.0, 3.1)  # of the mean square of a feature
STIFFNESSES = np.logspace(-9.0, 6.0, 121)  # tried ratios, of the typical strength of the data

# -- policy: what is worth a word, whatever the data -----------------------------------------------

INSIDE = 0.1  # of a simpler effect's torque, that may lie beside the finding it is part of
MATERIAL_REST = MATERIAL  # times the noise floor: one for all that judge
STANDS_IN = 2.0  # times the floor, and structured: what is named there may be a part of that
STANDS_BESIDE_MORE = 1.5  # the same where it is more than what is named took, structured or not
COMMON_SHARE = 0.3  # of a joint's squared error that a cause in common has to take
FORETOLD_MISSED = 0.9  # of what a set foretells: quantities without which as much is, are not told
UNSURE_FLOOR = 0.2  # relative standard error of a noise floor, from which on it is told with it
OF_NOISE = 0.5  # of what a finding took, that noise of the angles makes: most of it is no effect
SHARE_OFF = 4.0  # standard errors by which a torque is more or less than its shape says: one of ten
# thousand right ones
SHARE_FAR = 0.1  # of a torque, by which it is told as more or less than that
LEVEL = 0.1  # sine of the angle to the vertical, from which on gravity loads a first joint
OWN_SHARE = 0.3  # of its squared error that an effect's own joint loses where it is told by that
BROKEN_SHARE = 0.5  # of a joint's squared error, gone where runs, or their two parts, may differ:
#   most of it
FARTHEST_AXIS = 0.3  # rad by which an axis may point elsewhere: a URDF is wrong by less or by 90°,
#   and a first order tells no more
FARTHEST_ORIGIN = 0.3  # of the arm's longest link, that a joint may sit elsewhere, likewise
ANGLE_LEAST_TURNS = 8.0  # of a ripple within the way of its joint, as of what rings or hums in
#   time: fewer are a Fourier part of any curve over the angle
SEEN_SHARE = 0.2  # of an effect's largest torque; a fit that saw less extrapolates it (a)
MATERIAL_HARM = 0.01  # a rise of RMS below this is no reason to refuse (a)
SHARE_OF_GAIN = 0.25  # nor is a loss that is small beside what the candidate gains (a)
UNHEARD = 100.0  # times its noise: a joint that tells the fit nothing, its rows weigh 1e-4 (d)
SIDE_BLOCKS = (6, 5, 7, 8)  # alternate blocks of time of a run that must serve both sides: of
#   these the first after which both have seen most (six alone: d)
LEAST_SEEN = 1e-3  # of the largest direction of a motion: less is no motion

# -- chosen, on simulated seven-joint arms with stiction and the four shared real robots -----------

BEYOND_NOISE = 2.0  # times the floor: policy, told though nothing but the size speaks for it
BEYOND_SLOW_NOISE = 10.0  # where slow noise was not seen; that of the simulated arms reaches 7
MATERIAL_GAIN = 0.05  # least drop of RMS on the joint it helps most: smaller is the pipeline's own
PART_OF_THE_WAY = (0.5, 0.25, 0.0)  # to the loads of the last fit, where all of it leaves more
MUCH_WORSE = 0.25  # rise of one joint's RMS for which, if significant, no finding is worth it
AS_WELL = 1.2  # the same of a gain that sways: findings that leave more may stand in for it
#   (policy)
OUTDONE = 2.5  # times the squared error of a map: findings that leave more are imitations
SLOPES = (0.5, 1.8)  # held-out slope of a real effect; shapes and loads are refined after adding
SAME_DIRECTION = 0.8  # cosine of two predicted changes above which they are rivals
WORTH_JUDGING = 0.5  # of the best variant's gain: a wave had imitated a bump on the fit side
KNOWN_GROUND = 0.15  # of the held-out samples: a map of less is no description of the joint
MOSTLY_BEYOND = 0.5  # of the error, beyond the share of time, that lies where the fit side has not
#   been, to say so: most of it (policy; a fact of the two sides, no claim)
CARRIED_FARTHER = 1.5  # times what its coefficients leave open on the fit side: from there the
#   held-out side asks for what fitted runs do not determine (policy; 0.8 to 1.3 on like motion)
MOVED_FAR = 2.0  # times what a frozen model leaves where it may move, as it was given: three
#   quarters of the squared error lay in what its own data left open
FIRM = 10.0  # times: a model that hardly moves, where moving explains less than one change
#   (policy; ten times more gives the same)
USUAL = 2.0  # times what a model lacked on its own data: other motion may show as much more of it
#   (policy; two arms that nobody here wrote showed 0.8 to 1.4, decision 0228)
RUNAWAY = 1e3  # times all torque of a joint: what a map says where two of its knots were one
UNKNOWN_GROUND = 0.1  # weight of unvisited knots above which a sample is none of the map's
FEW_VISITS = 2.0  # samples at a knot below which the map does not know what is there
WIDER = 2.0  # times the usual distance from a standstill, to see what reversals do to estimates
BLIND = 10.0  # times the variance: too few samples lie far from reversals to tell anything

# -- chosen, on data that nobody wrote down; halved and doubled since (scripts/sensitivity.py) -----
#
# On three arms of two links and one of seven with known answers, and on the LWR4 (decision 0190):
# (a) no answer and no error changed; (b) other names for what is unexplained, no finding;
# (c) a finding came or went; (d) the same as (a), on arms of two links alone.

RING_STEP = 1.04  # between frequencies that are tried: as wide as a damping of 2 % resolves
RING_DAMPING = (0.01, 0.03, 0.1)  # of the critical one: what swings on
RING_NONE = 0.7  # what does not
RING_LEAST_TURNS = 8.0  # within the longest stretch
HUM_FINENESS = 4  # looks at a line in time within the resolution of the longest stretch
HUM_AROUND = 40  # resolutions to either side whose level a line has to stand above
HUM_LEAST_TURNS = 8.0  # of a line within the shorter of the longest stretches: fewer are slow noise
HUM_SHARE = 0.3  # of a joint's squared error that a line in time has to be: slow noise has less
HUM_ALIKE = 0.5  # of its size on the held-out side that it has on the fit side: a fan runs on
HUM_SAMPLES = 8000  # of a stretch that are looked at: a minute or two
CLAIMED_SHARE = 0.06  # of a joint's squared error that must come again, be predicted, or be removed
#   by a map where it knows, to be a claim (b: half names a map more, twice one less)
WORTH_A_ROUND = 0.02  # drop of the errors' logarithms, summed over the joints (a)
TIMING_AGREE = 0.6  # share of the joints' weight that must agree with a common offset (a)
LEAST_SLOPE = 0.4  # of the held-out residual on a map (b: twice it one map less, half nothing)
CLUSTERS = 2.5  # t of a map's drop over blocks of time: 0.6 % one-sided (b: twice it two maps less)
SMOOTH_TAILS = 1e-3  # share of samples at either end that do not widen a map's range (d, but for
#   0.5 % of its held-out error)
SMOOTHING_HZ = 0.2  # band over which the noise spectrum is averaged (c: at half and at twice the
#   LWR4's ripple on joint 7 goes, which is marginal, and joint 6 gets another map)
FEWEST_ORDINATES = 8  # of a periodogram that tells whether noise rises towards zero
DRIFT_ORDINATES = 32  # of it over which noise that does not drift is taken for white
DRIFT_SPAN = 1e-3  # of the strongest direction of what motion may leave: less is none
LINE_ABOVE = 10.0  # times its neighbours' power that a line of a motion has at least
DRIFT_MEMORIES = (1.0, 0.5, 0.25, 0.125)  # times the length of the run
DRIFT_POWERS = tuple(10.0 ** (0.25 * k) for k in range(-4, 21))  # at the first ordinate, over white
HIGHEST_ORDER = 220.0  # cycles per revolution of the strongest ripple that is looked for (a)
HIGHEST_OF_SLIDES = 3200.0  # rad/m likewise: a screw of 2 mm pitch
LEAST_TURNS = 2.0  # of a screw within the way of a slide: fewer look like a spring
BLOCK_SECONDS = 2.0  # of time that counts as one draw where the drop is judged by blocks (a)
MAP_KNOTS = 8  # hat functions per variable of a map of two (c: at 16 a map is claimed on a clean
#   joint of the arm with Stribeck friction; at 4 the LWR4's joint 6 gets another map)
MAP_FINE_KNOTS = 24  # of a map of one (a, without the LWR4)
MAP_FLAT_KNOTS = 2  # the two ends: a map straight along each variable, which goes on beyond them
MAP_MEMORIES = (0.4, 2.0)  # s: where the joint has been lately (d)
FORETOLD_WORK = (0.5, 1.5, 4.0)  # s over which a joint's work of late is remembered (d)
FORETOLD_TURNS = (5.0, 20.0, 60.0)  # s: which way a joint went of late (b: half and twice claim the
#   same of friction that follows the last minute, half a tenth more of its error)
FORETOLD_SHARP = 0.02  # of a joint's fast speed: within that its friction turns round (d)
PASSED_BAND = 1.5  # times the motion's highest frequency, up to which torque winds a spring:
#   beyond, its noise does, twice differentiated (c, on 20 arms of two links of which one swings at
#   2 to 12 Hz: 18 springs are named in their joint, 17 at half, 18 at twice, with one arm lost and
#   another won; on 10 stiff arms never a spring)
PASSED_ZETA = 0.05  # damping ratio from which a spring is sought; gears have 0.02 to 0.1 (on
#   the same 30 arms no name changes at a quarter and at four times; of three others one fit ends
#   at fourteen times the error from twice that, c)
