// A drinking glass, in metres: a cone with a wall of 2 mm and a thick bottom, on a short stem that is held.
SetFactory("OpenCASCADE");
wall = 0.002;
Cone(1) = {0, 0, 0, 0, 0, 0.09, 0.022, 0.034};
Cone(2) = {0, 0, 0.006, 0, 0, 0.09, 0.022 + 0.0008 - wall, 0.034 + 0.0008 - wall};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Cylinder(4) = {0, 0, -0.008, 0, 0, 0.008, 0.012};
BooleanUnion(5) = { Volume{3}; Delete; }{ Volume{4}; Delete; };

Physical Volume("glass") = {5};
foot() = Surface In BoundingBox{-0.013, -0.013, -0.0081, 0.013, 0.013, -0.0079};
Physical Surface("foot") = {foot()};

Mesh.ElementOrder = 2;
Mesh.MeshSizeMax = 0.006;
