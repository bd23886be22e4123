// Half cavity of a mold whose skin rises over the middle of its length: 25 mm at the ends, 33 mm at the crown.
// Lengths in m. The symmetry plane is y = 0; cells shrink towards the skin.
length = 1.0;
height = 0.025;
rise = 0.008;
skin = 0.003;
along = 24;      // cells along the flow
across = 22;     // cells across the bed
points = 20;     // of the splines

Point(1) = {0, 0, 0};
Point(2) = {length, 0, 0};
For i In {0 : points}
    z = length * i / points;
    y = height + rise * Sin(Pi * i / points) ^ 2;
    Point(100 + i) = {z, y, 0};
    Point(200 + i) = {z, y + skin, 0};
EndFor

Line(1) = {1, 2};
Line(2) = {2, 100 + points};
Spline(3) = {100 : 100 + points};
Line(4) = {1, 100};
Line(5) = {100, 200};
Spline(6) = {200 : 200 + points};
Line(7) = {100 + points, 200 + points};

Curve Loop(1) = {1, 2, -3, -4};
Plane Surface(1) = {1};
Curve Loop(2) = {3, 7, -6, -5};
Plane Surface(2) = {2};

Transfinite Curve {1, 3, 6} = along + 1;
Transfinite Curve {2, 4} = across + 1 Using Progression 1 / 1.3;
Transfinite Curve {5, 7} = 2;
Transfinite Surface {1} = {1, 2, 100 + points, 100};
Transfinite Surface {2} = {100, 100 + points, 200 + points, 200};
Recombine Surface {1, 2};

Physical Surface("bed") = {1};
Physical Surface("wall") = {2};
Physical Curve("inlet") = {4};
Physical Curve("outlet") = {2};
Physical Curve("interface") = {3};
Physical Curve("outer") = {6};
Physical Curve("symmetry") = {1};
