;@ if and else
DEF MAIN()
DECL INT I
I = 4
IF I > 3 THEN
  $OUT[1] = TRUE
ELSE
  $OUT[2] = TRUE
ENDIF
IF I > 5 THEN
  $OUT[3] = TRUE
ENDIF
END
;> out 1 = 1
;@ a loop with an exit
DEF MAIN()
DECL INT I
I = 0
LOOP
  I = I + 1
  IF I == 3 THEN
    EXIT
  ENDIF
  $ANOUT[1] = I
ENDLOOP
$ANOUT[2] = I
END
;> anout 1 = 1
;> anout 1 = 2
;> anout 2 = 3
;@ for, up and down
DEF MAIN()
DECL INT I
FOR I = 1 TO 3
  $ANOUT[1] = I
ENDFOR
FOR I = 6 TO 1 STEP -2
  $ANOUT[2] = I
ENDFOR
FOR I = 2 TO 1
  $ANOUT[3] = I
ENDFOR
$ANOUT[4] = I
END
;> anout 1 = 1
;> anout 1 = 2
;> anout 1 = 3
;> anout 2 = 6
;> anout 2 = 4
;> anout 2 = 2
;> anout 4 = 2
;@ while
DEF MAIN()
DECL INT I
I = 8
WHILE I > 1
  I = I / 2
ENDWHILE
$ANOUT[1] = I
END
;> anout 1 = 1
;@ repeat is done at least once
DEF MAIN()
DECL INT I
I = 10
REPEAT
  I = I + 1
UNTIL I > 5
$ANOUT[1] = I
END
;> anout 1 = 11
;@ switch over numbers
DEF MAIN()
DECL INT I
FOR I = 1 TO 4
  SWITCH I
  CASE 1
    $ANOUT[1] = 10
  CASE 2, 3
    $ANOUT[1] = 20
  DEFAULT
    $ANOUT[1] = 30
  ENDSWITCH
ENDFOR
END
;> anout 1 = 10
;> anout 1 = 20
;> anout 1 = 20
;> anout 1 = 30
;@ switch over an enumeration
DEF MAIN()
DECL COLOUR C
C = #GREEN
SWITCH C
CASE #RED
  $OUT[1] = TRUE
CASE #GREEN
  $OUT[2] = TRUE
ENDSWITCH
END
DEFDAT MAIN
ENUM COLOUR RED, GREEN
ENDDAT
;> out 2 = 1
;@ goto, forwards and back
DEF MAIN()
DECL INT I
I = 0
AGAIN:
I = I + 1
IF I < 3 THEN
  GOTO AGAIN
ENDIF
GOTO OVER
$OUT[1] = TRUE
OVER:
$ANOUT[1] = I
END
;> anout 1 = 3
;@ halt
DEF MAIN()
$OUT[1] = TRUE
HALT
$OUT[2] = TRUE
END
;> out 1 = 1
;> halted
;@ a loop without an end and without a wait
DEF MAIN()
DECL INT I
LOOP
  I = 1
ENDLOOP
END
;> failed: too-large 4
;@ a loop that asks for an input runs once in a cycle
;times
;< 0.03 1 1
DEF MAIN()
WHILE $IN[1] == FALSE
ENDWHILE
$OUT[1] = TRUE
END
;> 0.03 out 1 = 1
;@ waiting for a time
;times
DEF MAIN()
WAIT SEC 0.25
$OUT[1] = TRUE
WAIT SEC 0
$OUT[2] = TRUE
END
;> 0.25 out 1 = 1
;> 0.25 out 2 = 1
;@ waiting for an input
;times
;< 0.5 3 1
DEF MAIN()
WAIT FOR $IN[3]
$OUT[1] = TRUE
END
;> 0.50 out 1 = 1
;@ a timer
;times
DEF MAIN()
$TIMER[1] = 0
$TIMER_STOP[1] = FALSE
WAIT FOR $TIMER[1] >= 100
$TIMER_STOP[1] = TRUE
WAIT SEC 0.1
$ANOUT[1] = $TIMER[1]
END
;> 0.20 anout 1 = 100
;@ a cyclic flag follows its inputs
;< 0.1 2 1
DEF MAIN()
$CYCFLAG[1] = $IN[1] OR $IN[2]
WAIT FOR $CYCFLAG[1]
$OUT[1] = TRUE
END
;> out 1 = 1
;@ a pulse
DEF MAIN()
PULSE($OUT[4], TRUE, 0.5)
END
;> out 4 = 1 for 0.5 s beside
