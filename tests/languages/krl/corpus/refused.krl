;@ all that is wrong at once
DEF MAIN()
DECL INTT I
I = 1
J = 2
NOWHERE()
GOTO MISSING
EXIT
END
;> refused: unknown-name 2:11
;> refused: unknown-name 4:1
;> refused: unknown-name 5:1
;> refused: syntax 7:1
;> refused: unknown-name 6:1
;@ each word that is not supported
DEF MAIN()
ANOUT ON CHANNEL_1 = 1.0
CWRITE(1)
PTP {A1 0}
MKSPTP
END
;> refused: unsupported 2:1
;> refused: unsupported 3:1
;> refused: unsupported 5:1
;@ blocks that are not closed
DEF MAIN()
IF TRUE THEN
  $OUT[1] = TRUE
END
;> refused: syntax 4:1
;@ what is no statement
DEF MAIN()
3 = 4
X +
)
END
;> refused: syntax 2:1
;> refused: syntax 3:1
;> refused: syntax 4:1
;@ no ELSEIF
DEF MAIN()
IF TRUE THEN
ELSEIF FALSE THEN
ENDIF
END
;> refused: syntax 3:1
;@ statements outside of a program
HALT
DEF MAIN()
END
;> refused: syntax 1:1
;@ a text without its end
DEF MAIN()
DECL CHAR T[5]
T[] = "abc
END
;> refused: syntax 3:7
;> refused: syntax 3:11
;@ an input is not written
DEF MAIN()
$IN[1] = TRUE
END
;> refused: conflict 2:1
;@ the parameters of the program that runs
DEF MAIN(X:IN)
DECL INT X
END
;> refused: unsupported 1:1
;@ too many arguments
DEF MAIN()
ONE(1, 2)
END
DEF ONE(X:IN)
DECL INT X
END
;> refused: wrong-size 2:1
;@ a signal that is not there
DEF MAIN()
$OUT[500] = TRUE
END
;> failed: unknown-name 2
;@ what may not stand in a spline
DEF MAIN()
SPLINE
  SPL {X 1.0}
  $OUT[1] = TRUE
ENDSPLINE
END
;> refused: unsupported 4:3
