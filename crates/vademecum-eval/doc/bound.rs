// Included at the top of documentation tests, out of their sight: files of the repository, and a scene with a
// state and loads.

#[allow(unused_imports)]
use vademecum_eval::format::File;
#[allow(unused_imports)]
use vademecum_eval::*;

/// A body of 3 modes in both structures: a loadable surface, the load pattern "pull", three probes.
#[allow(dead_code)]
const BODY: &[u8] =
    include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/fixed-f64.vdm"));

/// A body of 4 modes in the block structure with the live parameters "soft", "hard", "step" and "dense".
#[allow(dead_code)]
const LIVE: &[u8] =
    include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/parameters.vdm"));

/// A body of 3 coordinates in the strain structure: a loadable surface, the load pattern "pull", three
/// probes.
#[allow(dead_code)]
const BENT: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/bent.vdm"));

/// Binds a file. The names of what it leaves are given to it, because a macro's own names stay its own.
#[allow(unused_macros)]
macro_rules! bound {
    (
        $bytes:expr, $structure:ident:
        $file:ident, $sizes:ident, $scene:ident, $state:ident, $loads:ident, $work:ident
    ) => {
        let $file = File::parse($bytes)?;
        let options = SceneOptions { structure: StructureChoice::$structure, ..SceneOptions::default() };
        let $sizes = Scene::<f64>::sizes(&$file, &options)?;
        let (mut memory, mut $work) = (vec![0.0; $sizes.scene], vec![0.0; $sizes.work]);
        let (mut state_memory, mut load_memory) = (vec![0.0; $sizes.state], vec![0.0; $sizes.loads]);
        #[allow(unused_mut)]
        let mut $scene = Scene::bind(&$file, &options, &mut memory, &mut $work)?;
        #[allow(unused_mut, unused_variables)]
        let mut $state = State::new(&$scene, &mut state_memory)?;
        #[allow(unused_mut, unused_variables)]
        let mut $loads = Loads::new(&$scene, &mut load_memory)?;
    };
}
