// A chair of solid wood, in metres: a seat on four legs, two of which go on to the back, and a rail at each side. It is cut into
// bricks of 20 nodes along the lines below; `fine` of them take the place of one along each edge.
SetFactory("OpenCASCADE");
DefineConstant[ fine = 1 ];
x() = {0, 0.035, 0.15, 0.27, 0.385, 0.42};
y() = {0, 0.035, 0.15, 0.26, 0.365, 0.4};
z() = {0, 0.1, 0.2, 0.235, 0.33, 0.43, 0.45, 0.6, 0.75, 0.85};
For k In {0:8}
  For j In {0:4}
    For i In {0:4}
      side = i == 0 || i == 4;
      back = j == 4;
      leg = side && (j == 0 || back) && k < 6;
      post = side && back && k > 5;
      rail = side && k == 2;
      rest = back && k == 8;
      If (leg || post || rail || rest || k == 5)
        Box(newv) = {x(i), y(j), z(k), x(i + 1) - x(i), y(j + 1) - y(j), z(k + 1) - z(k)};
      EndIf
    EndFor
  EndFor
EndFor
Coherence;

Physical Volume("beech") = Volume{:};
feet() = Surface In BoundingBox{-1, -1, -1e-4, 1, 1, 1e-4};
Physical Surface("feet") = {feet()};

Transfinite Curve "*" = fine + 1;
Transfinite Surface "*";
Recombine Surface "*";
Transfinite Volume "*";
Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;
