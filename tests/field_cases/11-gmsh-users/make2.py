import gmsh

# free quads with recombination that leaves a few triangles in the bed
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
src = (
    open("pipe.geo")
    .read()
    .replace("Transfinite Surface {1, 2};", "Transfinite Surface {2};")
    .replace(
        "Transfinite Curve {2, 4} = across + 1 Using Progression 1 / 1.3;",
        "Transfinite Curve {2} = 7; Transfinite Curve {4} = 8;",
    )
    .replace("along + 1 Using Progression 1.08", "along + 2")
)
src += "\nMesh.RecombinationAlgorithm=0;\nMesh.Algorithm=6;\n"
open("_t.geo", "w").write(src)
gmsh.open("_t.geo")
gmsh.model.mesh.generate(2)
for dim, tag in gmsh.model.getEntities(2):
    t, e, _ = gmsh.model.mesh.getElements(2, tag)
    print(tag, [(int(a), len(b)) for a, b in zip(t, e)])
gmsh.write("leftover.msh")
gmsh.finalize()
# two wall layers not connected with one another
