;@ values from the data list
DEF MAIN()
$ANOUT[1] = COUNT
$ANOUT[2] = P1.X
END
DEFDAT MAIN PUBLIC
DECL INT COUNT = 5
DECL E6POS P1 = {X 12.5, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0, S 2, T 10, E1 0.0}
ENDDAT
;> anout 1 = 5
;> anout 2 = 12.5
;@ an array in the data list
DEF MAIN()
DECL INT I
FOR I = 1 TO 3
  $ANOUT[1] = TAB[I]
ENDFOR
END
DEFDAT MAIN
DECL REAL TAB[3]
TAB[1] = 1.5
TAB[2] = 2.5
TAB[3] = 3.5
ENDDAT
;> anout 1 = 1.5
;> anout 1 = 2.5
;> anout 1 = 3.5
;@ arrays of two indices
DEF MAIN()
DECL INT I, J, M[2,3]
FOR I = 1 TO 2
  FOR J = 1 TO 3
    M[I, J] = 10 * I + J
  ENDFOR
ENDFOR
$ANOUT[1] = M[1, 3] + M[2, 1]
END
;> anout 1 = 34
;@ an index that is out of range
DEF MAIN()
DECL INT A[3]
A[4] = 1
END
;> failed: out-of-range 3
;@ structures of structures
DEF MAIN()
DECL PART P
P.COUNT = 3
P.AT = {X 1.0, Y 2.0, Z 3.0, A 0.0, B 0.0, C 0.0}
P.AT.Z = 7.0
$ANOUT[1] = P.COUNT + P.AT.Z
END
DEFDAT MAIN
STRUC PART INT COUNT, FRAME AT, BOOL GOOD
ENDDAT
;> anout 1 = 10
;@ a structure as a whole
DEF MAIN()
DECL PART P, Q
P = {COUNT 2, AT {X 5.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}}
Q = P
Q.COUNT = 9
$ANOUT[1] = P.COUNT + Q.AT.X
END
DEFDAT MAIN
STRUC PART INT COUNT, FRAME AT
ENDDAT
;> anout 1 = 7
;@ a constant is not written
DEF MAIN()
LIMIT = 3
END
DEFDAT MAIN
DECL CONST INT LIMIT = 2
ENDDAT
;> refused: conflict 2:1
;@ signals by names
;< 0 2 1
DEF MAIN()
IF READY THEN
  GRIPPER = TRUE
ENDIF
END
DEFDAT MAIN
SIGNAL READY $IN[2]
SIGNAL GRIPPER $OUT[7]
ENDDAT
;> out 7 = 1
;@ flags
DEF MAIN()
$FLAG[10] = TRUE
$OUT[1] = $FLAG[10] AND NOT $FLAG[11]
END
;> out 1 = 1
;@ a constant that its enumeration does not have
DEF MAIN()
DECL COLOUR C
C = #BLUE
END
DEFDAT MAIN
ENUM COLOUR RED, GREEN
ENDDAT
;> failed: wrong-type 3
;@ texts
DEF MAIN()
DECL CHAR NAME[8]
NAME[] = "part"
$OUT[1] = NAME[] == "part"
END
;> out 1 = 1
