;@ a value in and a value out
DEF MAIN()
DECL INT N
N = 4
DOUBLE(N)
KEEP(N)
$ANOUT[1] = N
END
DEF DOUBLE(X:OUT)
DECL INT X
X = 2 * X
END
DEF KEEP(X:IN)
DECL INT X
X = 100
END
;> anout 1 = 8
;@ a function in an expression
DEF MAIN()
$ANOUT[1] = SQUARE(3) + SQUARE(SQUARE(2))
END
DEFFCT INT SQUARE(X:IN)
DECL INT X
RETURN X * X
ENDFCT
;> anout 1 = 25
;@ a function in the condition of a loop
DEF MAIN()
DECL INT I
I = 0
WHILE BELOW(I)
  I = I + 1
ENDWHILE
$ANOUT[1] = I
END
DEFFCT BOOL BELOW(X:IN)
DECL INT X
RETURN X < 5
ENDFCT
;> anout 1 = 5
;@ recursion
DEF MAIN()
$ANOUT[1] = FACTORIAL(6)
END
DEFFCT INT FACTORIAL(N:IN)
DECL INT N
IF N < 2 THEN
  RETURN 1
ENDIF
RETURN N * FACTORIAL(N - 1)
ENDFCT
;> anout 1 = 720
;@ recursion without an end
DEF MAIN()
DOWN()
END
DEF DOWN()
DOWN()
END
;> failed: too-large 5
;@ arrays go in and out
DEF MAIN()
DECL INT A[3]
FILL(A[])
$ANOUT[1] = A[1] + A[2] + A[3]
END
DEF FILL(B[]:OUT)
DECL INT B[], I
FOR I = 1 TO 3
  B[I] = I
ENDFOR
END
;> anout 1 = 6
;@ a motion in a function
DEF MAIN()
IF MOVED() THEN
  $OUT[1] = TRUE
ENDIF
END
DEFFCT BOOL MOVED()
PTP {A1 10, A2 0, A3 0, A4 0, A5 0, A6 0}
RETURN TRUE
ENDFCT
;> plan ptp (10 0 0 0 0 0)
;> done PTP {A1 10, A2 0, A3 0, A4 0, A5 0, A6 0}
;> out 1 = 1
;@ leaving early
DEF MAIN()
TRY(1)
TRY(2)
END
DEF TRY(N:IN)
DECL INT N
IF N == 1 THEN
  RETURN
ENDIF
$ANOUT[1] = N
END
;> anout 1 = 2
;@ a function that returns nothing
DEF MAIN()
$ANOUT[1] = NONE()
END
DEFFCT INT NONE()
END
;> refused: syntax 5:1
;@ a call that the cell carries out
DEF MAIN()
PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
GRIP()
END
;> plan ptp (1 0 0 0 0 0)
;> done PTP {A1 1, A2 0, A3 0, A4 0, A5 0, A6 0}
;> call GRIP
