// Half cavity and skin of the planar mold of studies/mold (thesis, figure 8.2).
// Lengths in m. The bed lies between the symmetry plane at y = 0 and the wall; cells shrink towards the wall and the inlet.
length = 1.0;
width = 0.025;
thickness = 0.003;
along = 24;      // cells along the flow
across = 22;     // cells across the bed
through = 1;     // cells through the wall

Point(1) = {0, 0, 0};
Point(2) = {length, 0, 0};
Point(3) = {0, width, 0};
Point(4) = {length, width, 0};
Point(5) = {0, width + thickness, 0};
Point(6) = {length, width + thickness, 0};
Line(1) = {1, 2};
Line(2) = {2, 4};
Line(3) = {3, 4};
Line(4) = {1, 3};
Line(5) = {3, 5};
Line(6) = {5, 6};
Line(7) = {4, 6};
Curve Loop(1) = {1, 2, -3, -4};
Plane Surface(1) = {1};
Curve Loop(2) = {3, 7, -6, -5};
Plane Surface(2) = {2};

Transfinite Curve {1, 3, 6} = along + 1 Using Progression 1.08;
Transfinite Curve {2, 4} = across + 1 Using Progression 1 / 1.3;
Transfinite Curve {5, 7} = through + 1;
Transfinite Surface {1, 2};
Recombine Surface {1, 2};

Physical Surface("bed") = {1};
Physical Surface("wall") = {2};
Physical Curve("inlet") = {4};
Physical Curve("outlet") = {2};
Physical Curve("interface") = {3};
Physical Curve("outer") = {6};
Physical Curve("symmetry") = {1};
