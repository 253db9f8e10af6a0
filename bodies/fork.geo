// A tuning fork, in metres: two prongs, half a ring between them, and a stem to hold it by; bricks of 20 nodes. `fine` of them
// take the place of one along each edge.
DefineConstant[ fine = 1 ];
thick = 0.006;      // of a prong, in the direction in which it swings
deep = 0.008;       // across
inner = 0.005;      // of the ring
outer = inner + thick;
long = 0.0952;      // of a prong, above the ring
stem = 0.036;       // below the ring
half = Asin(0.004 / outer);

// Corners of the halves, inside and outside, from the stem over the ring to the end of a prong.
Point(1) = {0, 0, 0};
For s In {0:1}
  x = 2 * s - 1;
  p = 10 * (s + 1);
  Point(p + 1) = {x * inner * Sin(half), 0, -inner * Cos(half)};
  Point(p + 2) = {x * outer * Sin(half), 0, -outer * Cos(half)};
  Point(p + 3) = {x * inner, 0, 0};
  Point(p + 4) = {x * outer, 0, 0};
  Point(p + 5) = {x * inner, 0, long};
  Point(p + 6) = {x * outer, 0, long};
  Point(p + 7) = {x * outer * Sin(half), 0, -outer * Cos(half) - stem};
  Line(p + 1) = {p + 1, p + 2};
  Line(p + 2) = {p + 3, p + 4};
  Line(p + 3) = {p + 5, p + 6};
  Circle(p + 4) = {p + 1, 1, p + 3};
  Circle(p + 5) = {p + 2, 1, p + 4};
  Line(p + 6) = {p + 3, p + 5};
  Line(p + 7) = {p + 4, p + 6};
  Line(p + 8) = {p + 2, p + 7};
  Curve Loop(p + 1) = {p + 1, p + 5, -(p + 2), -(p + 4)};
  Curve Loop(p + 2) = {p + 2, p + 7, -(p + 3), -(p + 6)};
  Plane Surface(p + 1) = {p + 1};
  Plane Surface(p + 2) = {p + 2};
  Transfinite Curve {p + 1, p + 2, p + 3} = fine + 1;
  Transfinite Curve {p + 4, p + 5} = 3 * fine + 1;
  Transfinite Curve {p + 6, p + 7} = 6 * fine + 1;
  Transfinite Curve {p + 8} = 2 * fine + 1;
EndFor
Circle(1) = {11, 1, 21};
Circle(2) = {12, 1, 22};
Line(3) = {17, 27};
Transfinite Curve {1, 2, 3} = fine + 1;
Curve Loop(1) = {1, 21, -2, -11};
Curve Loop(2) = {2, 28, -3, -18};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Transfinite Surface "*";
Recombine Surface "*";
Extrude { 0, deep, 0 } { Surface{1, 2, 11, 12, 21, 22}; Layers{2 * fine}; Recombine; }

Physical Volume("steel") = Volume{:};
e = 1e-5;
z = -outer * Cos(half) - stem;
end() = Surface In BoundingBox{-outer, -e, z - e, outer, deep + e, z + e};
Physical Surface("stem end") = {end()};

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;
