// Half of a tool of 1.2 x 0.8 m, from its middle plane (z = 0) to its long side (z = 0.4 m), with a curved skin of 3 mm: the cavity is
// 50 mm high at its ends and 80 mm at its crown, of which the half above its own middle plane (y = 0) is meshed. Air enters through
// a port of 60 mm in each half of the short side x = 0 and leaves through one of 60 mm in the middle of the other. A second pair of
// outlets lies opposite the inlets; they are walls unless a scene opens them: groups = { outlet = "outlet + second_outlets" }.
length = 1.2; skin = 0.003; height = 0.025; crown = 0.015;
fine = 1;  // factor on the number of cells in each direction; they are smallest at the edges of the ports, where the flow gathers
along = 40 * fine; across = 6 * fine; points = 12;

// sections along the tool, at these distances from the middle plane: ports end where blocks end
z[] = {0, 0.03, 0.17, 0.23, 0.4};
beside[] = {4 * fine, 8 * fine, 4 * fine, 9 * fine};

For i In {0 : 4}
    swell = crown * Cos(0.5 * Pi * z[i] / 0.5);
    For level In {0 : 2}
        list[] = {};
        For n In {0 : points}
            x = length * n / points;
            top = height + swell * Sin(Pi * n / points);
            If (level == 0)
                y = 0;
            ElseIf (level == 1)
                y = top;
            Else
                y = top + skin;
            EndIf
            p = newp; Point(p) = {x, y, z[i]};
            list[] += p;
        EndFor
        c = newc; Spline(c) = {list[]};
        curve~{i}~{level} = c; first~{i}~{level} = list[0]; last~{i}~{level} = list[points];
        Transfinite Curve {c} = along + 1 Using Bump 0.05;
    EndFor
    For level In {0 : 1}
        upper = level + 1;
        a = newc; Line(a) = {first~{i}~{level}, first~{i}~{upper}}; up_in~{i}~{level} = a;
        b = newc; Line(b) = {last~{i}~{level}, last~{i}~{upper}}; up_out~{i}~{level} = b;
        Transfinite Curve {a, b} = (level == 0 ? across : 1) + 1;
        l = newll; Curve Loop(l) = {a, curve~{i}~{upper}, -b, -curve~{i}~{level}};
        s = news; Surface(s) = {l}; section~{i}~{level} = s;
        Transfinite Surface {s}; Recombine Surface {s};
    EndFor
EndFor

For i In {0 : 3}
    j = i + 1;
    For level In {0 : 2}
        a = newc; Line(a) = {first~{i}~{level}, first~{j}~{level}}; side_in~{i}~{level} = a;
        b = newc; Line(b) = {last~{i}~{level}, last~{j}~{level}}; side_out~{i}~{level} = b;
        If (i == 0)
            Transfinite Curve {a, b} = beside[i] + 1 Using Progression 0.8 ^ (1 / fine);
        ElseIf (i == 3)
            Transfinite Curve {a, b} = beside[i] + 1 Using Progression 1.25 ^ (1 / fine);
        Else
            Transfinite Curve {a, b} = beside[i] + 1 Using Bump 0.2;
        EndIf
        l = newll; Curve Loop(l) = {a, curve~{j}~{level}, -b, -curve~{i}~{level}};
        s = news; Surface(s) = {l}; sheet~{i}~{level} = s;
        Transfinite Surface {s}; Recombine Surface {s};
    EndFor
    For level In {0 : 1}
        upper = level + 1;
        l = newll; Curve Loop(l) = {up_in~{i}~{level}, side_in~{i}~{upper}, -up_in~{j}~{level}, -side_in~{i}~{level}};
        s = news; Surface(s) = {l}; end_in~{i}~{level} = s;
        Transfinite Surface {s}; Recombine Surface {s};
        l = newll; Curve Loop(l) = {up_out~{i}~{level}, side_out~{i}~{upper}, -up_out~{j}~{level}, -side_out~{i}~{level}};
        s = news; Surface(s) = {l}; end_out~{i}~{level} = s;
        Transfinite Surface {s}; Recombine Surface {s};
        l = newsl;
        Surface Loop(l) = {section~{i}~{level}, section~{j}~{level}, sheet~{i}~{level}, sheet~{i}~{upper},
                           end_in~{i}~{level}, end_out~{i}~{level}};
        v = newv; Volume(v) = {l}; block~{i}~{level} = v;
        Transfinite Volume {v};
    EndFor
EndFor

Physical Volume("bed") = {block_0_0, block_1_0, block_2_0, block_3_0};
Physical Volume("wall") = {block_0_1, block_1_1, block_2_1, block_3_1};
Physical Surface("inlet") = {end_in_2_0};
Physical Surface("outlet") = {end_out_0_0};
Physical Surface("second_outlets") = {end_out_2_0};
Physical Surface("symmetry") = {sheet_0_0, sheet_1_0, sheet_2_0, sheet_3_0, section_0_0};
Physical Surface("side") = {section_0_1, section_4_0, section_4_1, end_in_0_0, end_in_1_0, end_in_3_0, end_out_1_0, end_out_3_0,
                            end_in_0_1, end_in_1_1, end_in_2_1, end_in_3_1, end_out_0_1, end_out_1_1, end_out_2_1, end_out_3_1};
Physical Surface("interface") = {sheet_0_1, sheet_1_1, sheet_2_1, sheet_3_1};
Physical Surface("outer") = {sheet_0_2, sheet_1_2, sheet_2_2, sheet_3_2};
