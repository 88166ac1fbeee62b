;@ three motions ahead
DEF MAIN()
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
PTP {A1 2}
PTP {A1 3}
PTP {A1 4}
PTP {A1 5}
END
;> plan ptp (1 0 0 0 0 0)
;> plan ptp (2 0 0 0 0 0)
;> plan ptp (3 0 0 0 0 0)
;> plan ptp (4 0 0 0 0 0)
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> plan ptp (5 0 0 0 0 0)
;> done PTP {A1 2}
;> done PTP {A1 3}
;> done PTP {A1 4}
;> done PTP {A1 5}
;@ one motion ahead
DEF MAIN()
$ADVANCE = 1
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
PTP {A1 2}
PTP {A1 3}
END
;> plan ptp (1 0 0 0 0 0)
;> plan ptp (2 0 0 0 0 0)
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> plan ptp (3 0 0 0 0 0)
;> done PTP {A1 2}
;> done PTP {A1 3}
;@ no motion ahead
DEF MAIN()
$ADVANCE = 0
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
PTP {A1 2}
END
;> plan ptp (1 0 0 0 0 0)
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> plan ptp (2 0 0 0 0 0)
;> done PTP {A1 2}
;@ an output waits for the motion
DEF MAIN()
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
$OUT[1] = TRUE
PTP {A1 2}
END
;> plan ptp (1 0 0 0 0 0)
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> out 1 = 1
;> plan ptp (2 0 0 0 0 0)
;> done PTP {A1 2}
;@ with CONTINUE it does not
DEF MAIN()
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
CONTINUE
$OUT[1] = TRUE
PTP {A1 2}
END
;> plan ptp (1 0 0 0 0 0)
;> out 1 = 1 beside
;> plan ptp (2 0 0 0 0 0)
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> done PTP {A1 2}
;@ CONTINUE counts once
DEF MAIN()
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
CONTINUE
$OUT[1] = TRUE
$OUT[2] = TRUE
END
;> plan ptp (1 0 0 0 0 0)
;> out 1 = 1 beside
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> out 2 = 1
;@ an input is asked after the motion
;< 0.3 1 1
DEF MAIN()
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
IF $IN[1] THEN
  PTP {A1 2}
ENDIF
END
;> plan ptp (1 0 0 0 0 0)
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> plan ptp (2 0 0 0 0 0)
;> done PTP {A1 2}
;@ with CONTINUE it is asked before
;< 0.3 1 1
DEF MAIN()
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
CONTINUE
IF $IN[1] THEN
  PTP {A1 2}
ENDIF
END
;> plan ptp (1 0 0 0 0 0)
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;@ variables are counted ahead
DEF MAIN()
DECL INT I
FOR I = 1 TO 3
  PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
ENDFOR
$ANOUT[1] = I
END
;> plan ptp (1 0 0 0 0 0)
;> plan ptp (1 0 0 0 0 0)
;> plan ptp (1 0 0 0 0 0)
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> anout 1 = 4
;@ what a motion needs is taken when it is given
DEF MAIN()
DECL E6AXIS P
P = {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
PTP P
P.A1 = 50
PTP P
END
;> plan ptp (1 0 0 0 0 0)
;> plan ptp (50 0 0 0 0 0)
;> done PTP P
;> done PTP P
;@ where the arm is stops the advance run
DEF MAIN()
PTP {A1 7, A2 0, A3 0, A4 0, A5 0, A6 0}
$ANOUT[1] = $AXIS_ACT.A1
$ANOUT[2] = $POS_ACT.X
END
;> plan ptp (7 0 0 0 0 0)
;> done PTP {A1 7, A2 0, A3 0, A4 0, A5 0, A6 0}
;> anout 1 = 7
;> anout 2 = 1007
;@ waiting keeps what comes behind from being planned
;times
DEF MAIN()
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0} C_PTP
WAIT SEC 0
PTP {A1 2}
END
;> 0.00 plan ptp (1 0 0 0 0 0) blend 0.25
;> 0.50 done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0} C_PTP
;> 0.50 plan ptp (2 0 0 0 0 0)
;> 1.00 done PTP {A1 2}
;@ a call does not stop it
DEF MAIN()
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
NEXT()
END
DEF NEXT()
PTP {A1 2}
END
;> plan ptp (1 0 0 0 0 0)
;> plan ptp (2 0 0 0 0 0)
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> done PTP {A1 2}
