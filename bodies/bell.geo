// A hand bell, in metres: a wall that is 4 mm thick and 6 mm at the lip, turned about the z axis; its crown is held by the rim of a
// hole. Bricks of 20 nodes; `fine` of them take the place of one along each edge.
DefineConstant[ fine = 1 ];
// The outside and the inside, from the hole to the lip.
Point(1) = {0.014, 0, 0.086};
Point(2) = {0.021, 0, 0.0845};
Point(3) = {0.0305, 0, 0.075};
Point(4) = {0.037, 0, 0.045};
Point(5) = {0.044, 0, 0.018};
Point(6) = {0.056, 0, 0};
Point(11) = {0.014, 0, 0.081};
Point(12) = {0.0185, 0, 0.0798};
Point(13) = {0.0265, 0, 0.0735};
Point(14) = {0.033, 0, 0.045};
Point(15) = {0.0395, 0, 0.018};
Point(16) = {0.050, 0, 0};
Spline(1) = {1, 2, 3, 4, 5, 6};
Spline(2) = {11, 12, 13, 14, 15, 16};
Line(3) = {1, 11};
Line(4) = {6, 16};
Curve Loop(1) = {1, 4, -2, -3};
Plane Surface(1) = {1};
Transfinite Curve {1, 2} = 6 * fine + 1;
Transfinite Curve {3, 4} = fine + 1;
Transfinite Surface {1};
Recombine Surface {1};
quarter1[] = Extrude { {0, 0, 1}, {0, 0, 0}, Pi / 2 } { Surface{1}; Layers{4 * fine}; Recombine; };
quarter2[] = Extrude { {0, 0, 1}, {0, 0, 0}, Pi / 2 } { Surface{quarter1[0]}; Layers{4 * fine}; Recombine; };
quarter3[] = Extrude { {0, 0, 1}, {0, 0, 0}, Pi / 2 } { Surface{quarter2[0]}; Layers{4 * fine}; Recombine; };
quarter4[] = Extrude { {0, 0, 1}, {0, 0, 0}, Pi / 2 } { Surface{quarter3[0]}; Layers{4 * fine}; Recombine; };

Physical Volume("bronze") = Volume{:};
hole() = Surface In BoundingBox{-0.0141, -0.0141, 0.08, 0.0141, 0.0141, 0.087};
Physical Surface("hole") = {hole()};

Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;
