//! A body in time and the mesh of its surface, without the engine.

use std::error::Error;

use vademecum_eval::format::{File, SectionKind};
use vademecum_eval::{Field, SceneOptions, Simulation};

/// The most that one frame makes up for \[s\], so that a slow frame does not make the next one slower.
const LONGEST: f64 = 0.25;

/// The surface as it has moved: places and normals of its nodes.
pub struct Drawn {
    /// Places.
    pub places: Vec<[f32; 3]>,
    /// Outward, of length one.
    pub normals: Vec<[f32; 3]>,
}

/// A body, its surface at rest and as it was drawn last.
pub struct Soft {
    body: Simulation<f32>,
    rest: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    displacement: Vec<f32>,
    /// Time that the steps so far have not covered \[s\].
    owed: f64,
}

impl Soft {
    /// The body of a file, at rest.
    ///
    /// # Errors
    /// If the bytes are no vademecum file, or one without a surface.
    pub fn new(bytes: Vec<u8>) -> Result<Self, Box<dyn Error>> {
        let body = Simulation::new(bytes, &SceneOptions::default())?;
        let file = body.file();
        let surface = file.metadata().n_surface_nodes as usize;
        let rest: Vec<f32> =
            numbers(file, SectionKind::NodeCoordinates)?.map(|number| number as f32).collect();
        let rest: Vec<[f32; 3]> = rest.as_chunks::<3>().0.iter().take(surface).copied().collect();
        let triangles =
            file.section(SectionKind::Triangles).ok_or("the file has no surface to draw")?.u32s()?;
        let triangles = triangles.as_chunks::<3>().0.iter().map(|t| t.map(u32::from_le_bytes)).collect();
        Ok(Self { displacement: vec![0.0; 3 * surface], body, rest, triangles, owed: 0.0 })
    }

    /// The steps that a frame of so many seconds takes.
    ///
    /// # Errors
    /// If the motion leaves the numbers of single precision.
    pub fn advance(&mut self, seconds: f64) -> Result<(), Box<dyn Error>> {
        let step = self.body.scene().parameters().time_step;
        self.owed = (self.owed + seconds).min(LONGEST);
        let steps = (self.owed / step) as usize;
        self.owed -= steps as f64 * step;
        self.body.step(steps)?;
        Ok(())
    }

    /// Adds a force \[N\] at the place of the surface that is nearest to `point` at rest; it acts until
    /// [`Soft::clear`].
    ///
    /// # Errors
    /// If the body cannot be touched there.
    pub fn push(&mut self, point: [f64; 3], force: [f64; 3]) -> Result<(), Box<dyn Error>> {
        let place = self.body.locate(point)?;
        self.body.push(&place, force)?;
        Ok(())
    }

    /// Takes all forces away.
    pub fn clear(&mut self) {
        self.body.clear();
    }

    /// Displacement at the place of the surface that is nearest to `point` at rest.
    ///
    /// # Errors
    /// If the body cannot be touched there.
    pub fn displacement(&self, point: [f64; 3]) -> Result<[f64; 3], Box<dyn Error>> {
        let place = self.body.locate(point)?;
        Ok(self.body.point(&place, Field::Displacement)?)
    }

    /// Names of the probes.
    pub fn probes(&self) -> impl Iterator<Item = &str> {
        self.body.file().probe_names()
    }

    /// The displacement that a probe shows.
    ///
    /// # Errors
    /// If there is no probe of this name.
    pub fn probe(&self, name: &str) -> Result<f64, Box<dyn Error>> {
        let probe = self.body.find_probe(name).ok_or_else(|| format!("no probe is called \"{name}\""))?;
        Ok(self.body.probe(probe, Field::Displacement)?)
    }

    /// Node numbers of the triangles, counter-clockwise from outside.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The surface as it has moved, the displacement magnified by `scale`.
    ///
    /// # Errors
    /// If the file does not show its surface.
    pub fn surface(&mut self, scale: f32) -> Result<Drawn, Box<dyn Error>> {
        self.body.surface_into(Field::Displacement, &mut self.displacement)?;
        let moved = self.displacement.as_chunks::<3>().0.iter();
        let places: Vec<[f32; 3]> =
            self.rest.iter().zip(moved).map(|(at, u)| added(*at, *u, scale)).collect();
        let mut normals = vec![[0.0; 3]; places.len()];
        for &corners in &self.triangles {
            let [a, b, c] = corners.map(|node| places[node as usize]);
            let normal = cross(added(b, a, -1.0), added(c, a, -1.0));
            for node in corners {
                normals[node as usize] = added(normals[node as usize], normal, 1.0);
            }
        }
        for normal in &mut normals {
            let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
            if length > 0.0 {
                *normal = normal.map(|x| x / length);
            }
        }
        Ok(Drawn { places, normals })
    }
}

fn numbers(file: &File<'_>, kind: SectionKind) -> Result<impl Iterator<Item = f64>, Box<dyn Error>> {
    let numbers: Vec<f64> = file.section(kind).ok_or("the file has no nodes")?.numbers()?.iter().collect();
    Ok(numbers.into_iter())
}

fn added(a: [f32; 3], b: [f32; 3], scale: f32) -> [f32; 3] {
    [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
