//! Pictures of the scene from the side, one for each instant, in one SVG.

use std::error::Error;
use std::fmt::Write;

use rapier3d_f64::prelude::*;
use vademecum_eval::Field;
use vademecum_eval::format::{File, SectionKind};

use crate::Coupled;
use crate::scene::{BALLS, BOX};

/// Size of a panel in pixels, pixels a metre, and columns.
const PANEL: [f64; 2] = [340.0, 250.0];
const SCALE: f64 = 480.0;
const COLUMNS: usize = 3;

/// Panels so far.
pub struct Picture {
    nodes: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
    panels: Vec<String>,
}

/// A point as it is seen: x to the right, z up, y away from the eye and a little up.
fn seen(at: Vector) -> [f64; 2] {
    [28.0 + SCALE * (at.x + 0.12 * at.y), PANEL[1] - 60.0 - SCALE * (at.z + 0.3 * at.y)]
}

fn numbers(file: &File<'_>, kind: SectionKind) -> Result<Vec<f64>, Box<dyn Error>> {
    Ok(file.section(kind).ok_or("a section is missing")?.numbers()?.iter().collect())
}

impl Picture {
    /// Of the surface of the deformable body.
    ///
    /// # Errors
    /// If the file has no surface.
    pub fn new(coupled: &Coupled) -> Result<Self, Box<dyn Error>> {
        let file = coupled.body.file();
        let nodes = numbers(file, SectionKind::NodeCoordinates)?;
        let nodes = nodes.as_chunks::<3>().0.iter().map(|&at| Vector::from(at)).collect();
        let triangles = file.section(SectionKind::Triangles).ok_or("no triangles")?.u32s()?;
        let triangles = triangles.as_chunks::<3>().0.iter().map(|t| t.map(u32::from_le_bytes)).collect();
        Ok(Self { nodes, triangles, panels: vec![] })
    }

    /// Adds a panel.
    ///
    /// # Errors
    /// If the file does not show its surface.
    pub fn add(
        &mut self,
        name: &str,
        coupled: &Coupled,
        balls: &[RigidBodyHandle; 2],
        box_: RigidBodyHandle,
    ) -> Result<(), Box<dyn Error>> {
        let mut moved = vec![0.0; 3 * coupled.body.file().metadata().n_surface_nodes as usize];
        coupled.body.surface_into(Field::Displacement, &mut moved)?;
        let moved = moved.as_chunks::<3>().0;
        let at = |node: u32| self.nodes[node as usize] + Vector::from(moved[node as usize]);
        let mut faces: Vec<[Vector; 3]> = self.triangles.iter().map(|t| t.map(at)).collect();
        // What is far away is drawn first.
        let depth = |face: &[Vector; 3]| face.iter().map(|at| at.z - at.y).sum::<f64>();
        faces.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
        let mut out = String::new();
        for [a, b, c] in faces {
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let light = 58.0 + 30.0 * normal.dot(Vector::new(-0.4, -0.5, 0.77)).max(0.0);
            let corners = [a, b, c].map(|at| seen(at).map(|x| format!("{x:.1}")).join(",")).join(" ");
            writeln!(
                out,
                r##"<polygon points="{corners}" fill="hsl(160 30% {light:.0}%)" stroke="#3a5a50" stroke-width=".3"/>"##
            )?;
        }
        let rigid = |of: RigidBodyHandle| *coupled.world.bodies[of].position();
        let mut shapes = vec![(box_, None)];
        shapes.extend(balls.iter().zip(BALLS).map(|(&ball, radius)| (ball, Some(radius))));
        shapes.sort_by(|a, b| rigid(b.0).translation.y.total_cmp(&rigid(a.0).translation.y));
        for (of, radius) in shapes {
            let pose = rigid(of);
            match radius {
                Some(radius) => {
                    let [x, y] = seen(pose.translation);
                    let r = SCALE * radius;
                    writeln!(
                        out,
                        r##"<circle cx="{x:.1}" cy="{y:.1}" r="{r:.1}" fill="#c8553d" stroke="#5c2015"/>"##
                    )?;
                }
                None => out.push_str(&faces_of_box(&pose)),
            }
        }
        writeln!(out, r##"<text x="12" y="22" font-family="sans-serif" font-size="14">{name}</text>"##)?;
        self.panels.push(out);
        Ok(())
    }

    /// The whole picture.
    #[must_use]
    pub fn svg(&self) -> String {
        let rows = self.panels.len().div_ceil(COLUMNS);
        let (width, height) = (COLUMNS as f64 * PANEL[0], rows as f64 * PANEL[1]);
        let mut out = format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}"><rect width="100%" height="100%" fill="#fff"/>"##
        );
        for (i, panel) in self.panels.iter().enumerate() {
            let (x, y) = ((i % COLUMNS) as f64 * PANEL[0], (i / COLUMNS) as f64 * PANEL[1]);
            out.push_str(&format!("<g transform=\"translate({x} {y})\">\n{panel}</g>\n"));
        }
        out.push_str("</svg>\n");
        out
    }
}

/// The sides of the box that the eye sees.
fn faces_of_box(pose: &Pose) -> String {
    let [x, y, z, _] = BOX;
    let half = Vector::new(x, y, z);
    let mut faces = vec![];
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let corner = |u: f64, v: f64| {
                let mut at = [0.0; 3];
                (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (side, u, v);
                *pose * (Vector::from(at) * half)
            };
            let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            let mut normal = [0.0; 3];
            normal[axis] = side;
            let normal = pose.rotation * Vector::from(normal);
            // Towards the eye: the front, which is at low y, and the top.
            if normal.dot(Vector::new(-0.12, -1.0, 0.3)) > 0.0 {
                faces.push((corners, 45.0 + 25.0 * normal.z.max(0.0) + 8.0 * (-normal.y).max(0.0)));
            }
        }
    }
    let face = |(corners, light): &([Vector; 4], f64)| {
        let corners = corners.map(|at| seen(at).map(|x| format!("{x:.1}")).join(",")).join(" ");
        format!("<polygon points=\"{corners}\" fill=\"hsl(215 45% {light:.0}%)\" stroke=\"#1d3050\"/>\n")
    };
    faces.iter().map(face).collect()
}
