// A tuning fork of steel, in metres: two prongs, the bend between them, and a stem to hold it by.
SetFactory("OpenCASCADE");
thick = 0.006;      // of a prong, in the direction in which it swings
deep = 0.008;       // across
gap = 0.010;        // between the prongs
long = 0.0952;      // of a prong, above the bend
inner = gap / 2;
outer = inner + thick;

// The bend: half a ring below z = 0.
Cylinder(1) = {0, -deep / 2, 0, 0, deep, 0, outer};
Cylinder(2) = {0, -deep / 2, 0, 0, deep, 0, inner};
Box(3) = {-outer, -deep / 2, 0, 2 * outer, deep, outer};
BooleanDifference(4) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
Box(5) = {-outer, -deep / 2, 0, thick, deep, long};
Box(6) = {inner, -deep / 2, 0, thick, deep, long};
Cylinder(7) = {0, 0, -inner - 0.036, 0, 0, 0.034, 0.004};
BooleanUnion(8) = { Volume{4}; Delete; }{ Volume{5, 6, 7}; Delete; };

Physical Volume("steel") = {8};
end() = Surface In BoundingBox{-0.01, -0.01, -inner - 0.0361, 0.01, 0.01, -inner - 0.0359};
Physical Surface("stem end") = {end()};

Mesh.ElementOrder = 2;
Mesh.MeshSizeMax = 0.0045;
Mesh.MeshSizeFromCurvature = 8;
