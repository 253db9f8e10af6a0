//! The node, and the extension that registers it.

use godot::classes::mesh::{ArrayType, PrimitiveType};
use godot::classes::{ArrayMesh, FileAccess, IMeshInstance3D, MeshInstance3D};
use godot::prelude::*;

use crate::soft::{Drawn, Soft};

struct Extension;

#[gdextension]
unsafe impl ExtensionLibrary for Extension {}

/// A mesh instance that is the surface of a vademecum file. Points and forces are those of the node's own
/// frame.
#[derive(GodotClass)]
#[class(init, base = MeshInstance3D)]
pub struct VademecumBody {
    /// The file, such as `res://bell.vdm`.
    #[export(file = "*.vdm")]
    file: GString,
    /// Factor on the displacement that is drawn.
    #[export]
    #[init(val = 1.0)]
    magnify: f32,
    soft: Option<Soft>,
    base: Base<MeshInstance3D>,
}

#[godot_api]
impl IMeshInstance3D for VademecumBody {
    fn ready(&mut self) {
        let path = self.file.clone();
        if !path.is_empty() {
            self.open(path);
        }
    }

    fn physics_process(&mut self, delta: f64) {
        let Some(soft) = &mut self.soft else { return };
        if let Err(error) = soft.advance(delta) {
            godot_error!("{}: {error}", self.file);
            self.soft = None;
            return;
        }
        self.draw();
    }
}

#[godot_api]
impl VademecumBody {
    /// Opens a file, at rest; `false`, with a message, where it cannot be opened.
    #[func]
    fn open(&mut self, path: GString) -> bool {
        let bytes = FileAccess::get_file_as_bytes(&path).to_vec();
        self.soft = match Soft::new(bytes) {
            Ok(soft) => Some(soft),
            Err(error) => {
                godot_error!("{path}: {error}");
                None
            }
        };
        self.file = path;
        self.draw();
        self.soft.is_some()
    }

    /// Adds a force \[N\] at the place of the surface that is nearest to `point`. It acts until `clear`.
    #[func]
    fn push(&mut self, point: Vector3, force: Vector3) -> bool {
        let Some(soft) = &mut self.soft else { return false };
        told(soft.push(doubles(point), doubles(force))).is_some()
    }

    /// Takes all forces away.
    #[func]
    fn clear(&mut self) {
        if let Some(soft) = &mut self.soft {
            soft.clear();
        }
    }

    /// Displacement of the place of the surface that is nearest to `point` at rest.
    #[func]
    fn displacement(&self, point: Vector3) -> Vector3 {
        let moved = self.soft.as_ref().and_then(|soft| told(soft.displacement(doubles(point))));
        moved.map_or(Vector3::ZERO, |[x, y, z]| Vector3::new(x as real, y as real, z as real))
    }

    /// The displacement that a probe of the file shows.
    #[func]
    fn probe(&self, name: GString) -> f64 {
        self.soft.as_ref().and_then(|soft| told(soft.probe(&name.to_string()))).unwrap_or(0.0)
    }

    /// Names of the probes.
    #[func]
    fn probes(&self) -> PackedStringArray {
        self.soft.iter().flat_map(Soft::probes).map(GString::from).collect()
    }

    /// Puts the surface as it is now into the mesh.
    fn draw(&mut self) {
        let magnify = self.magnify;
        let Some(soft) = &mut self.soft else { return };
        let Some(Drawn { places, normals }) = told(soft.surface(magnify)) else { return };
        // Godot's front faces are clockwise.
        let corners: PackedInt32Array =
            soft.triangles().iter().flat_map(|&[a, b, c]| [a, c, b]).map(|node| node as i32).collect();
        let packed = |rows: Vec<[f32; 3]>| -> PackedVector3Array {
            rows.into_iter().map(|[x, y, z]| Vector3::new(x, y, z)).collect()
        };
        let mut arrays = VarArray::new();
        arrays.resize(ArrayType::MAX.ord() as usize, &Variant::nil());
        arrays.set(ArrayType::VERTEX.ord() as usize, &packed(places).to_variant());
        arrays.set(ArrayType::NORMAL.ord() as usize, &packed(normals).to_variant());
        arrays.set(ArrayType::INDEX.ord() as usize, &corners.to_variant());
        let mut mesh = match self.base().get_mesh().and_then(|mesh| mesh.try_cast::<ArrayMesh>().ok()) {
            Some(mesh) => mesh,
            None => ArrayMesh::new_gd(),
        };
        mesh.clear_surfaces();
        mesh.add_surface_from_arrays(PrimitiveType::TRIANGLES, &arrays);
        self.base_mut().set_mesh(&mesh);
    }
}

fn doubles(vector: Vector3) -> [f64; 3] {
    [vector.x, vector.y, vector.z].map(f64::from)
}

/// The result of a call that went well; an error goes to the console of Godot.
fn told<T>(result: Result<T, Box<dyn std::error::Error>>) -> Option<T> {
    result.inspect_err(|error| godot_error!("{error}")).ok()
}
