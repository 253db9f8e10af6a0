// A soft finger of a robot, in metres: half a capsule of silicone with an air chamber; its root is held.
SetFactory("OpenCASCADE");
DefineConstant[ fine = 1 ];
l = 0.09; r = 0.012; wall = 0.004;
Cylinder(1) = {0, 0, 0, l - r, 0, 0, r};
Sphere(2) = {l - r, 0, 0, r};
BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Box(4) = {-0.01, -0.1, -0.1, 0.2, 0.2, 0.1 - 0.4 * r};
BooleanDifference(5) = { Volume{3}; Delete; }{ Volume{4}; Delete; };
// The chamber, above the bottom that does not stretch.
Cylinder(6) = {2 * wall, 0, 0, l - r - 2 * wall, 0, 0, r - wall};
Box(7) = {-0.01, -0.1, -0.1, 0.2, 0.2, 0.1};
BooleanDifference(8) = { Volume{6}; Delete; }{ Volume{7}; Delete; };
BooleanDifference(9) = { Volume{5}; Delete; }{ Volume{8}; Delete; };

Physical Volume("silicone") = {9};
root() = Surface In BoundingBox{-1e-4, -0.1, -0.1, 1e-4, 0.1, 0.1};
Physical Surface("root") = {root()};
chamber() = Surface In BoundingBox{2 * wall - 1e-4, -r + wall - 1e-4, -1e-4, l - r + 1e-4, r - wall + 1e-4, r - wall + 1e-4};
Physical Surface("chamber") = {chamber()};

Mesh.ElementOrder = 2;
Mesh.SecondOrderLinear = 1;
Mesh.MeshSizeMax = 0.011 / fine;
