// A liver, in metres: two lobes that taper to the left, the lower side hollowed out where it rests on its neighbours.
SetFactory("OpenCASCADE");
DefineConstant[ fine = 1 ];
Sphere(1) = {0, 0, 0, 0.05};
Dilate { {0, 0, 0}, {1.6, 1.3, 1.0} } { Volume{1}; }
Sphere(2) = {0, 0, 0, 0.04};
Dilate { {0, 0, 0}, {1.9, 1.1, 0.7} } { Volume{2}; }
Rotate { {0, 1, 0}, {0, 0, 0}, Pi / 9 } { Volume{2}; }
Translate { -0.075, 0.008, 0.02 } { Volume{2}; }
BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Sphere(4) = {-0.02, -0.01, -0.115, 0.1};
// The bare area, by which it hangs on the diaphragm.
Box(5) = {-0.3, 0.045, -0.3, 0.6, 0.1, 0.6};
BooleanDifference(6) = { Volume{3}; Delete; }{ Volume{4, 5}; Delete; };

Physical Volume("liver") = {6};
bare() = Surface In BoundingBox{-0.3, 0.0449, -0.3, 0.3, 0.0451, 0.3};
Physical Surface("bare area") = {bare()};

Mesh.ElementOrder = 2;
Mesh.SecondOrderLinear = 1;
Mesh.MeshSizeMax = 0.026 / fine;
Mesh.MeshSizeMin = 0.016 / fine;
