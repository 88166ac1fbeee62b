;@ at the start and at the goal
DEF MAIN()
TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE
TRIGGER WHEN DISTANCE=1 DELAY=20 DO $OUT[2]=FALSE
LIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
LIN {X 1200.0}
END
;> plan lin (1100 0 0 mm) 2 m/s [start +0 s: out 1 = 1] [end +0.02 s: out 2 = 0]
;> plan lin (1200 0 0 mm) 2 m/s
;> done LIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
;> done LIN {X 1200.0}
;@ at a point of the path
DEF MAIN()
TRIGGER WHEN PATH=-30.0 DELAY=0 DO PULSE($OUT[3], TRUE, 0.2)
SLIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
END
;> plan lin (1100 0 0 mm) 2 m/s [path -30 mm +0 s: out 3 = 1]
;> done SLIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
;@ an analog output
DEF MAIN()
TRIGGER WHEN DISTANCE=0 DELAY=0 DO $ANOUT[1]=0.5
LIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
END
;> plan lin (1100 0 0 mm) 2 m/s [start +0 s: anout 1 = 0.5]
;> done LIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
;@ values are those of the statement
DEF MAIN()
DECL BOOL B
B = TRUE
TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=B
B = FALSE
LIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
END
;> plan lin (1100 0 0 mm) 2 m/s [start +0 s: out 1 = 1]
;> done LIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
;@ before the time
DEF MAIN()
TRIGGER WHEN DISTANCE=1 DELAY=-20 DO $OUT[1]=TRUE
LIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
END
;> failed: unsupported 2
;@ a call is not done by a trigger
DEF MAIN()
TRIGGER WHEN DISTANCE=0 DELAY=0 DO LATER() PRIO=-1
LIN {X 1100.0, Y 0.0, Z 0.0, A 0.0, B 0.0, C 0.0}
END
DEF LATER()
END
;> refused: unsupported 2:36
