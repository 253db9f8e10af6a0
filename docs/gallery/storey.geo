// A storey in metres: a plate on four legs, with the places of bolts under the legs and over them.
SetFactory("OpenCASCADE");
side = 0.2;
leg = 0.012;
height = 0.1;
plate = 0.01;
Box(1) = {0, 0, height, side, side, plate};
For i In {0:1}
  For j In {0:1}
    Box(2 + 2 * i + j) = {i * (side - leg), j * (side - leg), 0, leg, leg, height};
  EndFor
EndFor
For i In {0:1}
  For j In {0:1}
    Rectangle(1001 + 2 * i + j) = {i * (side - leg), j * (side - leg), height + plate, leg, leg};
  EndFor
EndFor
BooleanUnion(10) = { Volume{1}; Delete; }{ Volume{2:5}; Delete; };
BooleanFragments { Volume{10}; Delete; }{ Surface{1001:1004}; Delete; }

Physical Volume("steel") = Volume{:};
e = 1e-4;
For i In {0:1}
  For j In {0:1}
    n = 1 + 2 * i + j;
    x = i * (side - leg);
    y = j * (side - leg);
    foot() = Surface In BoundingBox{x - e, y - e, -e, x + leg + e, y + leg + e, e};
    Physical Surface(Sprintf("foot%g", n)) = {foot()};
    top() = Surface In BoundingBox{x - e, y - e, height + plate - e, x + leg + e, y + leg + e, height + plate + e};
    Physical Surface(Sprintf("top%g", n)) = {top()};
  EndFor
EndFor

Mesh.ElementOrder = 2;
Mesh.SecondOrderLinear = 1;
Mesh.MeshSizeMax = 0.02;
