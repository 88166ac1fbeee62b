;@ an output while the arm moves
;times
;< 0.2 1 1
DEF MAIN()
INTERRUPT DECL 10 WHEN $IN[1] == TRUE DO SEEN()
INTERRUPT ON 10
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
INTERRUPT OFF 10
END
DEF SEEN()
$OUT[1] = TRUE
END
;> 0.00 plan ptp (1 0 0 0 0 0)
;> 0.20 out 1 = 1 beside
;> 0.50 done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;@ stop and go on
;times
;< 0.2 1 1
DEF MAIN()
INTERRUPT DECL 10 WHEN $IN[1] DO STOP_IT()
INTERRUPT ON 10
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
PTP {A1 2}
END
DEF STOP_IT()
BRAKE
WAIT SEC 0.3
END
;> 0.00 plan ptp (1 0 0 0 0 0)
;> 0.00 plan ptp (2 0 0 0 0 0)
;> 0.20 brake
;> 0.50 go on
;> 0.80 done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> 1.30 done PTP {A1 2}
;@ stop and leave what was called
;< 0.2 1 1
DEF MAIN()
INTERRUPT DECL 10 WHEN $IN[1] DO FOUND()
INTERRUPT ON 10
SEARCH()
$OUT[2] = TRUE
END
DEF SEARCH()
LIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
$OUT[1] = TRUE
END
DEF FOUND()
BRAKE
RESUME
END
;> plan lin (1100 0 0 mm) 2 m/s
;> brake
;> forget
;> out 2 = 1
;@ a motion in an interrupt that has stopped the arm
;< 0.2 1 1
DEF MAIN()
INTERRUPT DECL 10 WHEN $IN[1] DO AWAY()
INTERRUPT ON 10
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
END
DEF AWAY()
BRAKE
PTP {A1 -5, A2 0, A3 0, A4 0, A5 0, A6 0}
END
;> plan ptp (1 0 0 0 0 0)
;> brake
;> plan ptp (-5 0 0 0 0 0)
;> done PTP {A1 -5, A2 0, A3 0, A4 0, A5 0, A6 0}
;> go on
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;@ a motion in one that has not
;< 0.2 1 1
DEF MAIN()
INTERRUPT DECL 10 WHEN $IN[1] DO AWAY()
INTERRUPT ON 10
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
END
DEF AWAY()
PTP {A1 -5, A2 0, A3 0, A4 0, A5 0, A6 0}
END
;> plan ptp (1 0 0 0 0 0)
;> failed: not-possible-now 7
;@ an edge, not a level
;< 0 1 1
DEF MAIN()
INTERRUPT DECL 10 WHEN $IN[1] DO SEEN()
WAIT SEC 0.1
INTERRUPT ON 10
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
END
DEF SEEN()
$OUT[1] = TRUE
END
;> plan ptp (1 0 0 0 0 0)
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;@ disabled, and then enabled again
;times
;< 0.2 1 1
DEF MAIN()
INTERRUPT DECL 10 WHEN $IN[1] DO SEEN()
INTERRUPT ON
INTERRUPT DISABLE 10
WAIT SEC 0.4
INTERRUPT ENABLE 10
WAIT SEC 0.1
END
DEF SEEN()
$OUT[1] = TRUE
END
;> 0.41 out 1 = 1 beside
;@ the smaller number first
;< 0.2 1 1
DEF MAIN()
INTERRUPT DECL 10 WHEN $IN[1] DO LATE()
INTERRUPT DECL 5 WHEN $IN[1] DO EARLY()
INTERRUPT ON
WAIT SEC 0.5
END
DEF LATE()
$OUT[1] = TRUE
END
DEF EARLY()
$OUT[2] = TRUE
END
;> out 2 = 1 beside
;> out 1 = 1 beside
;@ nothing to leave
;< 0.2 1 1
DEF MAIN()
INTERRUPT DECL 10 WHEN $IN[1] DO FOUND()
INTERRUPT ON 10
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
WAIT SEC 1
END
DEF FOUND()
BRAKE
RESUME
END
;> plan ptp (1 0 0 0 0 0)
;> brake
;> failed: not-possible-now 9
;@ an interrupt that nobody declared
DEF MAIN()
INTERRUPT ON 3
END
;> failed: unknown-name 2
;@ it ends with the program that declared it
;< 0.2 1 1
DEF MAIN()
SETUP()
WAIT SEC 0.5
END
DEF SETUP()
INTERRUPT DECL 10 WHEN $IN[1] DO SEEN()
INTERRUPT ON 10
END
DEF SEEN()
$OUT[1] = TRUE
END
;@ braking where nothing was interrupted
DEF MAIN()
BRAKE
END
;> failed: not-possible-now 2
;@ its arguments are those of the program that declared it
;< 0.2 1 1
DEF MAIN()
DECL INT A, B, C
C = 7
INTERRUPT DECL 10 WHEN $IN[1] DO SEEN(C)
INTERRUPT ON 10
BUSY()
END
DEF BUSY()
WAIT SEC 0.5
END
DEF SEEN(N:IN)
DECL INT N
$ANOUT[1] = N
END
;> anout 1 = 7 beside
;@ a global one knows no variables of its program
DEF MAIN()
DECL INT C
GLOBAL INTERRUPT DECL 10 WHEN C > 3 DO MAIN()
END
;> refused: unsupported 3:31
;@ a cyclic flag knows none either
DEF MAIN()
DECL BOOL B
$CYCFLAG[1] = B
END
;> refused: unsupported 3:15
;@ a switch without a word
DEF MAIN()
INTERRUPT
$OUT[1] = TRUE
END
;> refused: syntax 2:10
