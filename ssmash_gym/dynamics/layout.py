"""Rows of the kernel's tables, by name.

Every table is a structure of arrays ``(row, helicopter)`` of float64, SI units. The kernels and the code that
fills the tables share these names; no row number is written anywhere else. Symbols are those of the thesis
(Léveillé 2013, chapter 2 and appendix A).
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final

STATIONS: Final = 3
TIRES: Final = 6  # two a station; an unused second tire is skipped
STATION_NAMES: Final = ("auxiliary", "right", "left")

# --- state -----------------------------------------------------------------------------------------------


class State(IntEnum):
    """Rows of the state: generalized speeds u7-u18, coordinates q8-q29 (order of STATE.OUT), tires, claw, probe.

    The first `ODE_ROWS` rows are integrated; the rest is advanced by its own rules (claw drive, capture).
    """

    U7 = 0  # (2.21) helicopter velocity over the ship, S axes [m/s] (u7-u9)
    U8 = 1
    U9 = 2
    U10 = 3  # (2.22) helicopter angular velocity relative to the ship, H axes [rad/s] (u10-u12)
    U11 = 4
    U12 = 5
    U13 = 6  # (2.23) station 1: slide speed along o_z [m/s] or swing-arm rate about o_y [rad/s]
    U14 = 7  # (2.24) station 1: steer rate about o_z [rad/s]
    U15 = 8  # (2.25) station 2
    U16 = 9  # (2.26)
    U17 = 10  # (2.27) station 3
    U18 = 11  # (2.28)
    Q8 = 12  # (2.11) helicopter position r_SH_S [m] (q8-q10)
    Q9 = 13
    Q10 = 14
    Q11 = 15  # (2.12) Euler parameters H -> S (q11-q14)
    Q12 = 16
    Q13 = 17
    Q14 = 18
    Q15 = 19  # (2.13) station 1: distance O1 -> W1 along o_z [m], then Euler parameters O1 -> H
    Q16 = 20  # (2.14)
    Q20 = 24  # (2.15) station 2
    Q21 = 25  # (2.16)
    Q25 = 29  # (2.17) station 3
    Q26 = 30  # (2.18)
    TIRE = 34  # 6 tires x (d_x [m], d_y [m], psi [rad])
    CLAW_X = 52  # claw position and velocity in S [m], [m/s], ripple not included
    CLAW_Y = 53
    CLAW_VX = 54
    CLAW_VY = 55
    PROBE_CAPTURED = 56  # 1 captured, 0 not
    PROBE_LOST = 57  # 1 once the ultimate load has broken the probe
    DIVERGED = 58  # 0 healthy; else 1 + the row whose next value was not finite or absurd; the state is then held
    DIVERGED_CLOCK = 59  # substep at which that happened
    DIVERGED_VALUE = 60  # the value refused there, within +-1e308; 0 for a NaN: the state table holds numbers only


ODE_ROWS: Final = 52
STATE_ROWS: Final = 61
SPEEDS: Final = 12
STATION_COORDINATES: Final = 5  # q15-q19, q20-q24, q25-q29
TIRE_STATES: Final = 3

# --- prescribed deck kinematics (one instant) --------------------------------------------------------------


class Deck(IntEnum):
    """Rows of the ship's kinematics at one instant, as the equations of motion need it."""

    R_NS = 0  # 9 rows, row-major: takes S components to N components
    W_NS_S = 9  # angular velocity of the ship, S axes [rad/s] (u4-u6)
    WDOT_NS_S = 12  # component derivatives of w_NS_S [rad/s2]
    V_NS_N = 15  # velocity of the ship-frame origin in the steadily translating mean frame, N axes [m/s]
    A_NS_N = 18  # its acceleration [m/s2]
    C_CLAW_S = 21  # claw centre r_SC_S [m], ripple included
    V_CLAW_S = 24  # its velocity [m/s]
    ANGLES = 27  # roll, pitch, yaw [rad]
    WIND = 30  # wind that the helicopter meets, gust included: true wind minus the ship's mean velocity, N axes [m/s]


DECK_ROWS: Final = 33

# --- the kernel's scratch ------------------------------------------------------------------------------------


class Work(IntEnum):
    """Scratch rows of the equations of motion: the three joint blocks."""

    JOINT = 0  # 3 x JOINT_ROWS


class Joint(IntEnum):
    """Offsets of a joint pair (slide or swing, steer) from ``Work.JOINT + i * JOINT_ROWS``."""

    B1 = 0  # coupling column of the first joint speed: translation (H axes), rotation
    B2 = 6
    D11 = 12  # inverse of the 2x2 block of the pair
    D12 = 13
    D22 = 14
    N1 = 15  # right-hand sides
    N2 = 16
    C1 = 17  # secant slopes of the joint dissipation, kept from the first stage for the second
    C2 = 18


JOINT_ROWS: Final = int(Joint.C2) + 1
WORK_ROWS: Final = int(Work.JOINT) + STATIONS * JOINT_ROWS

# --- parameters ----------------------------------------------------------------------------------------------


class Par(IntEnum):
    """Rows of the parameter table that belong to the helicopter, the probe, the wind and the claw."""

    MASS = 0
    IXX = 1
    IXY = 2
    IXZ = 3
    IYY = 4
    IYZ = 5
    IZZ = 6
    GRAVITY = 7
    CP = 8  # centre of pressure r_HCP_H, 3 rows [m]
    AREA = 11  # equivalent drag areas A_eq, 3 rows [m2]
    AIR_DENSITY = 14
    WIND = 15  # mean true wind minus the ship's mean velocity, N axes, 3 rows [m/s]
    PROBE_ACTIVE = 18
    PROBE_MOUNT = 19  # r_Ha_H, 3 rows [m]
    PROBE_VECTOR = 22  # r_ac_H, 3 rows [m]
    PROBE_KS_X = 25
    PROBE_KS_Y = 26
    PROBE_KL_X = 27
    PROBE_KL_Y = 28
    PROBE_D_X = 29
    PROBE_D_Y = 30
    PROBE_C_X = 31
    PROBE_C_Y = 32
    PROBE_C_Z = 33
    PROBE_D_Z = 34
    PROBE_KS_Z = 35
    PROBE_KL_Z = 36
    PROBE_CAPTURE_RADIUS = 37
    PROBE_ULTIMATE = 38  # resultant load above which the probe is lost [N]
    CLAW_Z = 39
    CLAW_SPEED_X = 40  # speed that a command of 1 asks for [m/s]
    CLAW_SPEED_Y = 41
    CLAW_ACCEL_X = 42
    CLAW_ACCEL_Y = 43
    CLAW_X_MIN = 44
    CLAW_X_MAX = 45
    CLAW_Y_MIN = 46
    CLAW_Y_MAX = 47
    CLAW_DELAY = 48  # [s], a whole number of substeps
    RIPPLE_X = 49  # amplitude [m]
    RIPPLE_Y = 50
    RIPPLE_OMEGA = 51  # [rad/s]
    RIPPLE_PHASE = 52  # [rad]
    LOCK = 53  # 12 rows: 1 holds the speed u7..u18
    WRENCH_H = 65  # further force [N] and moment [N m] at the helicopter's c.g., H axes, 6 rows
    WRENCH_W = 71  # the same for the three carriages, W axes, 3 x 6 rows
    GUST = 89  # direction that the table's gust speed takes, N axes, 3 rows: a unit vector, or zero for no gust
    PATCH_X_MIN = 92  # rectangle of the deck with other friction, S axes [m]; read with `Mode.PATCH`
    PATCH_X_MAX = 93
    PATCH_Y_MIN = 94
    PATCH_Y_MAX = 95
    PATCH_LOSS = 96  # share of the friction that is missing on it: 1 - factor [1]
    PATCH_EDGE = 97  # width inside its border over which the friction changes [m]
    STATION = 98  # 3 x STATION_ROWS


class Sta(IntEnum):
    """Offsets of a station's rows from ``Par.STATION + i * STATION_ROWS``."""

    MASS = 0
    IXX = 1
    IXY = 2
    IXZ = 3
    IYY = 4
    IYZ = 5
    IZZ = 6
    MOUNT = 7  # r_HO_H, 3 rows [m]
    DROOP = 10  # r_OW_O at full droop, 3 rows [m]
    P1 = 13  # swing arm: oleo mount on the helicopter, H axes, 3 rows [m]
    P2 = 16  # swing arm: oleo mount on the arm, O axes, 3 rows [m]
    LENGTH = 19  # swing arm: |P1 P2| at full droop [m]
    ROLL_LOCK = 20  # 1: the wheels do not roll
    STEER_MU = 21  # mu_steer,eff [m]
    STEER_C = 22  # steer damping [N m s/rad]
    STEER_BETA = 23  # [s/rad]
    LINEAR_K = 24
    LINEAR_C = 25
    X0 = 26
    X1 = 27
    X2 = 28
    K = 29  # extension spring rate past full droop [N/m]
    GAS_P = 30
    GAS_V = 31
    GAS_A = 32
    GAS_GAMMA = 33
    P_REF = 34  # reference pressure to subtract in region 3 [Pa], 0 as in the thesis
    R2_C = 35  # region-2 constants c and d (2.210), (2.211), derived when the table is filled
    R2_D = 36
    E1 = 37
    E2 = 38
    F1 = 39
    F2 = 40
    G1 = 41
    G2 = 42
    C01 = 43
    C02 = 44
    C03 = 45
    C1 = 46
    C2 = 47
    C3 = 48
    C4 = 49
    C5 = 50
    C6 = 51
    C7 = 52
    C8 = 53
    C9 = 54
    REL1 = 55
    REL2 = 56
    SEAL = 57
    BEARING_Z = 58  # lower shaft bearing from the oleo origin along o_z [m]
    BEARING_L0 = 59  # bearing separation at full droop [m]
    BEARING_MU = 60
    BETA = 61  # [s/m]
    STROKE = 62
    STOP_K = 63
    STOP_C = 64
    STEER_PLAY = 65  # free play of a locked steering, to either side [rad]; this and the rows below with `Mode.PLAY`
    STEER_STOP_K = 66  # stiffness beyond it [N m/rad]
    STEER_STOP_C = 67  # damping beyond it [N m s/rad]
    STEER_COS = 68  # half the steer angle about which it is locked: cosine and sine, from the orientation at droop
    STEER_SIN = 69


class Tir(IntEnum):
    """Offsets of a tire's rows from ``TIRE_PAR + t * TIRE_ROWS``; tires 2 i and 2 i + 1 belong to station i."""

    X = 0  # r_WT_W, 3 rows [m]
    Y = 1
    Z = 2
    DIAMETER = 3
    WIDTH = 4
    AXLE_RADIUS = 5
    P_O = 6  # inflation pressure, gauge [Pa]
    P_R = 7  # rated pressure, gauge [Pa]
    P_ABS = 8  # initial absolute pressure [Pa]
    TYPE_I = 9  # 1 for type I, 0 for types III and VII
    MU = 10
    MU_RR = 11
    MU_AXLE = 12
    CTZ = 13
    CX = 14
    CY = 15
    CZ = 16
    BETA = 17  # decay constant of the rolling friction [s/m]
    SIGMA_MIN = 18  # least relaxation length [m]
    BOTTOM = 19  # deflection at which the rim is reached [m]
    BOTTOM_K = 20
    PULL = 21  # pull-back rate to the friction limit [1/s]
    MY_COEFF = 22  # signed coefficient of (2.159)
    LIN_KZ = 23  # linear tire: constant stiffnesses and relaxation length
    LIN_KX = 24
    LIN_KY = 25
    LIN_KPSI = 26
    LIN_SIGMA = 27


STATION_ROWS: Final = int(Sta.STEER_SIN) + 1
TIRE_ROWS: Final = len(Tir)
TIRE_PAR: Final = int(Par.STATION) + STATIONS * STATION_ROWS
PARAMETER_ROWS: Final = TIRE_PAR + TIRES * TIRE_ROWS

# --- plain integers of a batch ----------------------------------------------------------------------------


class Mode(IntEnum):
    """Entries of the integer vector that says what kind of helicopter and model a batch holds."""

    STATION_KIND = 0  # 3 entries, StationKind
    SPRING = 3  # 3 entries, Spring
    TIRES = 6  # 3 entries, 0-2
    TIRE_MODEL = 9  # TireModel
    FRICTION = 10  # Friction
    CONTACT = 11  # Contact
    PROBE_LAW = 12  # ProbeLaw
    PLAY = 13  # 3 entries, 1 where the locked steering has free play
    CLAW = 16  # ClawDrive
    PATCH = 17  # 1 where the deck has a patch of other friction (`Par.PATCH_X_MIN` and on)


MODES: Final = 18


class StationKind(IntEnum):
    """Appendix A, line 32."""

    PRISMATIC = 1
    SWING_ARM = 2


class Spring(IntEnum):
    """Appendix A, line 62; NONE leaves the joint to the external wrenches (oracle)."""

    NONE = 0
    LINEAR = 1
    GAS_OLEO = 2


class TireModel(IntEnum):
    """Law of all tires of a helicopter."""

    SMILEY_HORNE = 0
    LINEAR = 1


class Friction(IntEnum):
    """How the friction limit couples the tire forces."""

    LIMIT_SURFACE = 0
    FRICTION_CIRCLE = 1
    INDEPENDENT = 2


class Contact(IntEnum):
    """Where the tire's travel over the deck is taken."""

    CONTACT = 0
    CENTRE = 1


class ProbeLaw(IntEnum):
    """In-plane stiffness law of the securing probe."""

    POTENTIAL = 0
    ELLIPSE = 1
    PRINTED = 2


class ClawDrive(IntEnum):
    """Where the claw's motion comes from."""

    COMMANDED = 0
    PRESCRIBED = 1
