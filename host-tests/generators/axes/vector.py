"""Names of everything that the integrator is told, as numbers of a vector, and the controller's period (s)."""

TC = 2.5e-4  # controller period
# ---------------------------------------------------------------- effect vector indices
NAMES = """VISC QUAD STR_A STR_V STR_D ASYM CONST SPR_K SPR_X POSF SPOT_A SPOT_X SPOT_W SPOT_K
PF_A PF_P PF_PH PF_A2 PF_PH2 PM_A PM_P PM_PH PM_A2 PM_PH2 ENC_A ENC_P ENC_PH ENC_A2 ENC_PH2
TH_B TH_T0 RUN_A RUN_S AGE_A AGE_T0 AGE_D AGE_V VIB_A VIB_W VIB_PH LOAD_A LAG_A LAG_V LAG_TAU
TWO TWO_M1 TWO_K TWO_C TWO_GAP TWO_ENC TWO_FM STR_ID STR_AMP SP0 SP1 SP2 SP3 SP4 SP5 SP6 SP7
POS_LO POS_HI""".split()
for _i, _n in enumerate(NAMES):
    globals()[_n] = _i
NE = len(NAMES)
# laws (families inside the integrator)
F_ELEM, F_DAHL, F_EP, F_BW, F_BRISTLE = 0, 1, 2, 3, 4
