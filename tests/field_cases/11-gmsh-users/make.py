import gmsh, sys, re

src = open("pipe.geo").read()


def build(name, src=src, order=1, version=4.1, binary=0, scale=1, save_all=0, after=None):
    open("_t.geo", "w").write(src)
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open("_t.geo")
    gmsh.model.mesh.generate(2)
    if order > 1:
        gmsh.model.mesh.setOrder(order)
    if after:
        after()
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.option.setNumber("Mesh.ScalingFactor", scale)
    gmsh.option.setNumber("Mesh.SaveAll", save_all)
    gmsh.write(name)
    gmsh.finalize()


build("v41.msh")
build("v22.msh", version=2.2)
build("v40.msh", version=4.0)
build("v22b.msh", version=2.2, binary=1)
build("v41b.msh", binary=1)
build("order2.msh", order=2)
build("mm.msh", scale=1000)
build("saveall.msh", save_all=1)
nog = re.sub(r"Physical.*\n", "", src)
build("nogroups.msh", src=nog, save_all=1)
build("odd.msh", src=src.replace('"bed"', '"Bed"').replace('"inlet"', '"INLET"').replace('"outlet"', '"Outlet"'))
build(
    "numbers.msh",
    src=re.sub(
        r'\("(\w+)"\)',
        lambda m: "(%d)" % (["bed", "wall", "inlet", "outlet", "interface", "outer", "symmetry"].index(m.group(1)) + 1),
        src,
    ),
)
build(
    "openfoamish.msh",
    src=src.replace('"symmetry"', '"axis"').replace('"interface"', '"fluid_to_solid"').replace('"bed"', '"porous"'),
)
# RZ as MOOSE/OGS: axis x=0, flow along y
rz = re.sub(r"Point\((\d)\) = \{(.*?), (.*?), 0\}", r"Point(\1) = {\3, \2, 0}", src)
build("rz_y.msh", src=rz)
# mesh in x-z plane
xz = re.sub(r"Point\((\d)\) = \{(.*?), (.*?), 0\}", r"Point(\1) = {\2, 0, \3}", src)
build("xz.msh", src=xz)
# flow along -x (mirrored): inlet at x=length
build(
    "reverse.msh",
    src=src.replace('Physical Curve("inlet") = {4}', 'Physical Curve("inlet") = {2}').replace(
        'Physical Curve("outlet") = {2};\nPhysical Curve("interface")',
        'Physical Curve("outlet") = {4};\nPhysical Curve("interface")',
    ),
)
# offset from the axis
off = re.sub(r"Point\((\d)\) = \{(.*?), (.*?), 0\}", r"Point(\1) = {\2, \3 + 0.01, 0}", src)
build("offset.msh", src=off)
# inlet offset x0=0.3
x0 = re.sub(r"Point\((\d)\) = \{(.*?), (.*?), 0\}", r"Point(\1) = {\2 + 0.3, \3, 0}", src)
build("x0.msh", src=x0)
# missing outer group
build("noouter.msh", src=re.sub(r'Physical Curve\("outer"\).*\n', "", src))
build("nointerface.msh", src=re.sub(r'Physical Curve\("interface"\).*\n', "", src))
# negative orientation / flipped surfaces
build("flipped.msh", src=src.replace("Curve Loop(1) = {1, 2, -3, -4}", "Curve Loop(1) = {4, 3, -2, -1}"))
# duplicated interface nodes (no Coherence): wall with own points
dup = (
    src.replace("Point(5) =", "Point(13) = {0, width, 0};\nPoint(14) = {length, width, 0};\nPoint(5) =")
    .replace("Line(5) = {3, 5}", "Line(13) = {13,14};\nLine(5) = {13, 5}")
    .replace("Line(7) = {4, 6}", "Line(7) = {14, 6}")
    .replace("Curve Loop(2) = {3, 7", "Curve Loop(2) = {13, 7")
    .replace("Transfinite Curve {1, 3, 6}", "Transfinite Curve {1, 3, 6, 13}")
)
build("dupnodes.msh", src=dup)
# mixed triangles and quads
build("mixed.msh", src=src.replace("Recombine Surface {1, 2}", "Recombine Surface {1}"))
