;@ sums before comparisons
DEF MAIN()
$OUT[1] = 1 + 2 * 3 == 7
$OUT[2] = (1 + 2) * 3 == 9
END
;> out 1 = 1
;> out 2 = 1
;@ comparisons bind least
DEF MAIN()
DECL INT A
A = 3
$OUT[1] = (A > 2) AND (A < 5)
$OUT[2] = NOT (A == 3) OR (A <> 4)
$OUT[3] = (A >= 3) EXOR (A <= 2)
END
;> out 1 = 1
;> out 2 = 1
;> out 3 = 1
;@ whole numbers and real ones
DEF MAIN()
DECL INT I
DECL REAL R
I = 7 / 2
R = 7 / 2.0
$ANOUT[1] = I
$ANOUT[2] = R
I = 2.6
$ANOUT[3] = I
I = -2.6
$ANOUT[4] = I
END
;> anout 1 = 3
;> anout 2 = 3.5
;> anout 3 = 3
;> anout 4 = -3
;@ functions of numbers
DEF MAIN()
$ANOUT[1] = SIN(30) + COS(60.0)
$ANOUT[2] = ABS(-4) + SQRT(9)
$ANOUT[3] = ATAN2(1, 1)
$ANOUT[4] = ACOS(0.5) + TAN(45)
END
;> anout 1 = 1
;> anout 2 = 7
;> anout 3 = 45
;> anout 4 = 61
;@ bits
DEF MAIN()
DECL INT I
I = 'B1100' B_AND 10
$ANOUT[1] = I
$ANOUT[2] = I B_OR 'H3'
$ANOUT[3] = 6 B_EXOR 3
$ANOUT[4] = B_NOT 0
END
;> anout 1 = 8
;> anout 2 = 11
;> anout 3 = 5
;> anout 4 = -1
;@ numbers with exponents
DEF MAIN()
$ANOUT[1] = 1.5E2 + .5
$ANOUT[2] = 2E-1
END
;> anout 1 = 150.5
;> anout 2 = 0.2
;@ a frame in a frame
DEF MAIN()
DECL FRAME F, G
F = {X 100.0, Y 0.0, Z 0.0, A 90.0, B 0.0, C 0.0}
G = F : {FRAME: X 10.0, Y 0.0, Z 5.0, A 0.0, B 0.0, C 0.0}
$ANOUT[1] = G.X
$ANOUT[2] = G.Y
$ANOUT[3] = G.Z
$ANOUT[4] = G.A
END
;> anout 1 = 100
;> anout 2 = 10
;> anout 3 = 5
;> anout 4 = 90
;@ the inverse of a frame
DEF MAIN()
DECL FRAME F
F = {X 100.0, Y 50.0, Z 0.0, A 30.0, B 10.0, C 5.0}
F = INV_POS(F) : F
$OUT[1] = (ABS(F.X) < 0.001) AND (ABS(F.A) < 0.001)
END
;> out 1 = 1
;@ division by nothing
DEF MAIN()
DECL INT I
I = 0
$ANOUT[1] = 5 / I
END
;> failed: invalid-value 4
;@ a number that is too large
DEF MAIN()
DECL INT I
I = 2000000000
I = I + I
END
;> failed: invalid-value 4
;@ a value that was never set
DEF MAIN()
DECL INT I
$ANOUT[1] = I + 1
END
;> failed: invalid-value 3
;@ kinds that do not fit
DEF MAIN()
DECL BOOL B
B = 3
END
;> failed: wrong-type 3
