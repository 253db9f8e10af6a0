// A soft organ with a stiff inclusion under its surface, in metres: an egg that is cut flat where it lies, and a ball.
SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, 0.05};
Dilate { {0, 0, 0}, {1.4, 1.0, 0.8} } { Volume{1}; }
Box(2) = {-0.1, -0.1, -0.1, 0.2, 0.2, 0.08};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Sphere(4) = {0.025, 0.0, 0.022, 0.012};
BooleanFragments { Volume{3}; Delete; }{ Volume{4}; Delete; }

ball() = Volume In BoundingBox{0.012, -0.013, 0.009, 0.038, 0.013, 0.035};
all() = Volume{:};
flesh() = all();
flesh() -= ball();
Physical Volume("flesh") = {flesh()};
Physical Volume("inclusion") = {ball()};
bed() = Surface In BoundingBox{-0.1, -0.1, -0.0201, 0.1, 0.1, -0.0199};
Physical Surface("bed") = {bed()};

MeshSize { PointsOf{ Volume{ball()}; } } = 0.006;
Mesh.ElementOrder = 2;
Mesh.SecondOrderLinear = 1;
Mesh.MeshSizeMax = 0.011;
