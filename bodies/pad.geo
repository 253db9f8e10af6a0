// The pad in the palm of a robot's hand, in metres: a cushion with rounded sides on a flat back.
SetFactory("OpenCASCADE");
DefineConstant[ fine = 1 ];
Sphere(1) = {0, 0, 0, 0.03};
Dilate { {0, 0, 0}, {1.3, 1.0, 0.6} } { Volume{1}; }
Box(2) = {-0.1, -0.1, -0.1, 0.2, 0.2, 0.1};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };

Physical Volume("silicone") = {3};
back() = Surface In BoundingBox{-0.1, -0.1, -1e-4, 0.1, 0.1, 1e-4};
Physical Surface("back") = {back()};

Mesh.ElementOrder = 2;
Mesh.SecondOrderLinear = 1;
Mesh.MeshSizeMax = 0.009 / fine;
