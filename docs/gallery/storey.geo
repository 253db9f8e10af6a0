// Storeys in metres, one welded on the other: plates on four legs, with the places of bolts under and over the legs.
SetFactory("OpenCASCADE");
DefineConstant[ storeys = 1 ];
side = 0.2;
leg = 0.012;
height = 0.1;
plate = 0.01;
all = storeys * (height + plate);
For s In {0:storeys - 1}
  z = s * (height + plate);
  Box(1 + 5 * s) = {0, 0, z + height, side, side, plate};
  For i In {0:1}
    For j In {0:1}
      Box(2 + 5 * s + 2 * i + j) = {i * (side - leg), j * (side - leg), z, leg, leg, height};
    EndFor
  EndFor
EndFor
For i In {0:1}
  For j In {0:1}
    Rectangle(1001 + 2 * i + j) = {i * (side - leg), j * (side - leg), all, leg, leg};
  EndFor
EndFor
BooleanUnion(100) = { Volume{1}; Delete; }{ Volume{2:5 * storeys}; Delete; };
BooleanFragments { Volume{100}; Delete; }{ Surface{1001:1004}; Delete; }

Physical Volume("plastic") = Volume{:};
e = 1e-4;
For i In {0:1}
  For j In {0:1}
    n = 1 + 2 * i + j;
    x = i * (side - leg);
    y = j * (side - leg);
    foot() = Surface In BoundingBox{x - e, y - e, -e, x + leg + e, y + leg + e, e};
    Physical Surface(Sprintf("foot%g", n)) = {foot()};
    top() = Surface In BoundingBox{x - e, y - e, all - e, x + leg + e, y + leg + e, all + e};
    Physical Surface(Sprintf("top%g", n)) = {top()};
  EndFor
EndFor

Mesh.ElementOrder = 2;
Mesh.SecondOrderLinear = 1;
Mesh.MeshSizeMax = 0.025;
