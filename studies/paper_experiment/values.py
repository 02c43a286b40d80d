"""Every number of the paper's experiment (Calafiore, Indri and Bona 2001, sections 4-5)."""

PARAMETERS = (
    ("Gamma_1z + m_2 l_1^2", "kg m^2"),
    ("m_2 s_2x", "kg m"),
    ("m_2 s_2y", "kg m"),
    ("Gamma_2z", "kg m^2"),
    ("gamma_s1", "N m"),
    ("gamma_v1", "N m s/rad"),
    ("gamma_s2", "N m"),
    ("gamma_v2", "N m s/rad"),
)
MANUFACTURER = (3.689, 0.97, 0.0, 0.275)
J_K, J_D, DETERMINANT = 13.34, 17.9, 8e17
GENERATIONS = 20  # "under 20 generations"
FILTER_CUTOFF = 14.0  # [rad/s], "about"
OMEGA_MAX = 1.825  # [rad/s]
BANDWIDTH, PEAK_DB = 60.0, 4.0  # "about 60 rad/s", "at most 4 dB"
# By design (J_k, J_d); rms and relative by set (estimation, validation, test) and joint.
VARIANCES = ((3.069, 0.157), (113.77, 0.39))
ESTIMATES = (
    (3.923, 0.808, 0.328, 0.141, 2.61, 7.343, 1.460, 0.787),
    (3.445, 0.698, 0.012, 0.107, 0.500, 7.884, 1.023, 0.883),
)
DIAGONAL_P = (
    (0.0054, 0.0028, 0.0032, 0.0004, 0.0225, 0.0473, 0.0011, 0.0025),
    (0.0339, 0.0010, 0.0011, 0.0000, 1.0446, 0.5603, 0.0035, 0.0019),
)
RMS = (
    ((1.34, 0.24), (1.38, 0.23), (1.30, 0.31)),
    ((2.98, 0.24), (3.65, 0.31), (1.78, 0.40)),
)
RELATIVE = (
    ((0.15, 0.117), (0.165, 0.122), (0.172, 0.146)),
    ((0.203, 0.093), (0.266, 0.13), (0.238, 0.19)),
)
