// A quarter of a mold's cavity below a doubly curved skin of 3 mm, drawn in shell_mold.step (mm): 600 mm long, 150 mm from its
// middle to the side, 25 mm high at its edge and 36.7 mm at its crown. Lengths here in m.
SetFactory("OpenCASCADE");
Geometry.OCCTargetUnit = "M";
Merge "shell_mold.step";
Coherence;  // bed and wall get one common surface

length = 0.6; width = 0.15; height = 0.025; crown = 0.037; skin = 0.003;
along = 24; beside = 8; across = 8;  // cells along the flow, to the side, and from the middle to the skin
e = 1e-4; far = 1;

bed() = Volume In BoundingBox {-far, -e, -far, far, crown + e, far};
wall() = Volume In BoundingBox {-far, height - e, -far, far, far, far};
inlet() = Surface In BoundingBox {-e, -e, -far, e, height + e, far};
outlet() = Surface In BoundingBox {length - e, -e, -far, length + e, height + e, far};
symmetry() = Surface In BoundingBox {-far, -e, -far, far, e, far};
side() = Surface In BoundingBox {-far, -far, -e, far, far, e};
side() += Surface In BoundingBox {-far, -far, width - e, far, far, width + e};
ends() = Surface In BoundingBox {-e, height - e, -far, e, far, far};
ends() += Surface In BoundingBox {length - e, height - e, -far, length + e, far, far};
interface() = Abs(Boundary { Volume {bed()}; });
interface() -= {inlet(), outlet(), symmetry(), side()};
outer() = Abs(Boundary { Volume {wall()}; });
outer() -= {interface(), side(), ends()};

Transfinite Curve {:} = along + 1;
For i In {0 : 1}
    across_flow() = Curve In BoundingBox {i * length - e, -far, -far, i * length + e, far, far};
    Transfinite Curve {across_flow()} = beside + 1;
EndFor
For i In {0 : 1}
    For j In {0 : 1}
        x = i * length; z = j * width;
        upright() = Curve In BoundingBox {x - e, -e, z - e, x + e, height + e, z + e};
        Transfinite Curve {upright()} = across + 1;
        through() = Curve In BoundingBox {x - e, height - e, z - e, x + e, height + skin + e, z + e};
        Transfinite Curve {through()} = 2;
    EndFor
EndFor
Transfinite Surface {:};
Recombine Surface {:};
Transfinite Volume {:};

Physical Volume("bed") = {bed()};
Physical Volume("wall") = {wall()};
Physical Surface("inlet") = {inlet()};
Physical Surface("outlet") = {outlet()};
Physical Surface("symmetry") = {symmetry()};
Physical Surface("side") = {side()};
Physical Surface("interface") = {interface()};
Physical Surface("outer") = {outer()};
