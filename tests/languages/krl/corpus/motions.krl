;@ axes that are left out stay
DEF MAIN()
PTP {A1 10, A2 20, A3 30, A4 40, A5 50, A6 60}
PTP {A2 -5}
END
;> plan ptp (10 20 30 40 50 60)
;> plan ptp (10 -5 30 40 50 60)
;> done PTP {A1 10, A2 20, A3 30, A4 40, A5 50, A6 60}
;> done PTP {A2 -5}
;@ a line in a base with a tool
DEF MAIN()
$BASE = {X 500.0, Y 0.0, Z 100.0, A 0.0, B 0.0, C 0.0}
$TOOL = {X 0.0, Y 0.0, Z 50.0, A 0.0, B 0.0, C 0.0}
$VEL.CP = 0.25
LIN {X 100.0, Y 20.0, Z 0.0, A 0.0, B 0.0, C 0.0}
END
;> plan lin (600 20 100 mm) 0.25 m/s
;> done LIN {X 100.0, Y 20.0, Z 0.0, A 0.0, B 0.0, C 0.0}
;@ coordinates that are left out stay
DEF MAIN()
LIN {X 1000.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
LIN {Z 50.0}
END
;> plan lin (1000 0 0 mm) 2 m/s
;> plan lin (1000 0 50 mm) 2 m/s
;> done LIN {X 1000.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
;> done LIN {Z 50.0}
;@ relative motions
DEF MAIN()
PTP {A1 10, A2 0, A3 0, A4 0, A5 0, A6 0}
PTP_REL {A1 -4, A6 5}
LIN_REL {Y 25.0}
END
;> plan ptp (10 0 0 0 0 0)
;> plan ptp (6 0 0 0 0 5)
;> plan lin (1006 25 0 mm A 5) 2 m/s
;> done PTP {A1 10, A2 0, A3 0, A4 0, A5 0, A6 0}
;> done PTP_REL {A1 -4, A6 5}
;> done LIN_REL {Y 25.0}
;@ relative to the tool
DEF MAIN()
LIN {X 1000.0, Y 0.0, Z 0.0, A 90.0, B 0.0, C 0.0}
LIN_REL {X 10.0} #TOOL
END
;> plan lin (1000 0 0 mm A 90) 2 m/s
;> plan lin (1000 10 0 mm A 90) 2 m/s
;> done LIN {X 1000.0, Y 0.0, Z 0.0, A 90.0, B 0.0, C 0.0}
;> done LIN_REL {X 10.0} #TOOL
;@ an arc
DEF MAIN()
CIRC {X 1000.0, Y 100.0, Z 0.0, A 0.0, B 0.0, C 0.0}, {X 900.0, Y 200.0, Z 0.0, A 0.0, B 0.0, C 0.0}
END
;> plan circ (1000 100 0 mm) (900 200 0 mm) 2 m/s
;> done CIRC {X 1000.0, Y 100.0, Z 0.0, A 0.0, B 0.0, C 0.0}, {X 900.0, Y 200.0, Z 0.0, A 0.0, B 0.0, C 0.0}
;@ speeds and the override
DEF MAIN()
DECL INT I
FOR I = 1 TO 6
  $VEL_AXIS[I] = 50
  $ACC_AXIS[I] = 80
ENDFOR
$OV_PRO = 40
PTP {A1 10, A2 0, A3 0, A4 0, A5 0, A6 0}
$VEL.CP = 0.5
LIN_REL {X 10.0}
END
;> plan ptp (10 0 0 0 0 0) speed 0.2 acceleration 0.8
;> plan lin (1020 0 0 mm) 0.2 m/s
;> done PTP {A1 10, A2 0, A3 0, A4 0, A5 0, A6 0}
;> done LIN_REL {X 10.0}
;@ ways to approximate
DEF MAIN()
$APO.CPTP = 40
$APO.CDIS = 25
$APO.CVEL = 60
PTP {A1 10, A2 0, A3 0, A4 0, A5 0, A6 0} C_PTP
LIN_REL {X 100.0} C_DIS
LIN_REL {Y 100.0} C_VEL
SLIN_REL {Z 100.0} C_SPL
END
;> plan ptp (10 0 0 0 0 0) blend 0.2
;> plan lin (1110 0 0 mm) 2 m/s blend 25 mm
;> plan lin (1110 100 0 mm) 2 m/s blend 0.2
;> plan lin (1110 100 100 mm) 2 m/s blend 25 mm
;> done PTP {A1 10, A2 0, A3 0, A4 0, A5 0, A6 0} C_PTP
;> done LIN_REL {X 100.0} C_DIS
;> done LIN_REL {Y 100.0} C_VEL
;> done SLIN_REL {Z 100.0} C_SPL
;@ approximated by the angle
DEF MAIN()
$APO.CORI = 20
LIN {X 1000.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
LIN {X 1100.0, Y 0.0, Z 0.0, A 80.0, B 0.0, C 0.0} C_ORI
END
;> plan lin (1000 0 0 mm) 2 m/s
;> plan lin (1100 0 0 mm A 80) 2 m/s blend 0.25
;> done LIN {X 1000.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
;> done LIN {X 1100.0, Y 0.0, Z 0.0, A 80.0, B 0.0, C 0.0} C_ORI
;@ values for one motion
DEF MAIN()
SLIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0} WITH $VEL.CP = 0.1
SLIN_REL {X 10.0}
END
;> plan lin (1100 0 0 mm) 0.1 m/s
;> plan lin (1110 0 0 mm) 2 m/s
;> done SLIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0} WITH $VEL.CP = 0.1
;> done SLIN_REL {X 10.0}
;@ a spline
DEF MAIN()
SPLINE
  SPL {X 1000.0, Y 100.0, Z 0.0}
  SPL {X 1100.0, Y 100.0, Z 0.0}
  SPL {X 1100.0, Y 0.0, Z 0.0}
ENDSPLINE C_SPL
END
;> plan spline (1000 100 0 mm) (1100 100 0 mm) (1100 0 0 mm) 2 m/s blend 100 mm
;> done SPLINE
;@ the orientation stays
DEF MAIN()
$ORI_TYPE = #CONSTANT
LIN {X 1100.0, Y 0.0, Z 0.0, A 45.0, B 0.0, C 0.0}
END
;> plan lin (1100 0 0 mm) 2 m/s
;> done LIN {X 1100.0, Y 0.0, Z 0.0, A 45.0, B 0.0, C 0.0}
;@ a line to axes is none
DEF MAIN()
LIN {A1 10, A2 0, A3 0, A4 0, A5 0, A6 0}
END
;> failed: wrong-type 2
;@ the frame of a motion that is not supported
DEF MAIN()
$IPO_MODE = #TCP
LIN {X 1100.0, Y 0.0, Z 0.0}
END
;> failed: unsupported 3
