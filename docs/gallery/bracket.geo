// A steel bracket in metres: a plate with two bolt holes on a wall, an arm with a hole, a fillet between them.
SetFactory("OpenCASCADE");
t = 0.006; w = 0.04; h = 0.08; l = 0.07; r = 0.008;
Box(1) = {0, 0, 0, t, w, h};
Box(2) = {0, 0, 0, l, w, t};
Box(3) = {t, 0, t, r, w, r};
Cylinder(4) = {t + r, -0.01, t + r, 0, w + 0.02, 0, r};
BooleanDifference(5) = { Volume{3}; Delete; }{ Volume{4}; Delete; };
BooleanUnion(6) = { Volume{1}; Delete; }{ Volume{2, 5}; Delete; };
Cylinder(7) = {-0.01, w / 2, 0.035, 0.03, 0, 0, 0.004};
Cylinder(8) = {-0.01, w / 2, 0.065, 0.03, 0, 0, 0.004};
Cylinder(9) = {0.055, w / 2, -0.01, 0, 0, 0.03, 0.005};
BooleanDifference(10) = { Volume{6}; Delete; }{ Volume{7, 8, 9}; Delete; };

Physical Volume("steel") = {10};
wall() = Surface In BoundingBox{-1e-4, -1e-4, -1e-4, 1e-4, 0.041, 0.081};
Physical Surface("wall") = {wall()};
arm() = Surface In BoundingBox{-0.001, -0.001, 0.0059, 0.071, 0.041, 0.0061};
Physical Surface("arm") = {arm()};
// The walls of the holes.
lower() = Surface In BoundingBox{-1e-4, w / 2 - 0.0041, 0.0309, t + 1e-4, w / 2 + 0.0041, 0.0391};
Physical Surface("lower bolt") = {lower()};
upper() = Surface In BoundingBox{-1e-4, w / 2 - 0.0041, 0.0609, t + 1e-4, w / 2 + 0.0041, 0.0691};
Physical Surface("upper bolt") = {upper()};
seat() = Surface In BoundingBox{0.0499, w / 2 - 0.0051, -1e-4, 0.0601, w / 2 + 0.0051, t + 1e-4};
Physical Surface("seat") = {seat()};

Mesh.ElementOrder = 2;
Mesh.SecondOrderLinear = 1;
Mesh.MeshSizeMax = 0.006;
Mesh.MeshSizeFromCurvature = 16;
