// A flag pole of glass fibre, in metres: a round rod in layers of wedges.
SetFactory("OpenCASCADE");
DefineConstant[ fine = 1 ];
Disk(1) = {0, 0, 0, 0.03};
Extrude { 0, 0, 6 } { Surface{1}; Layers{16 * fine}; Recombine; }

Physical Volume("glass fibre") = {1};
foot() = Surface In BoundingBox{-1, -1, -1e-4, 1, 1, 1e-4};
Physical Surface("foot") = {foot()};

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;
Mesh.MeshSizeMax = 0.035 / fine;
