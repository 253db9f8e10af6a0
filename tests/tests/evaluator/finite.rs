//! Numbers of extreme size, and sizes of memory: what a call takes gives finite numbers, what it refuses
//! changes nothing, and no length wraps around.

use vademecum_eval::format::File;
use vademecum_eval::{
    BaseMotion, BindError, Body, BodyOptions, Field, MAX_CONTACTS, Place, PlaceError, Quantity, Scalar,
    Scene, SceneOptions, StructureChoice,
};
use vademecum_tests::program::fixtures;
use vademecum_tests::synthetic::Random;

/// Sizes that a caller may give by mistake.
const SIZES: [f64; 15] =
    [0.0, 5e-324, 1e-300, 1e-150, 1e-30, 1e-4, 1.0, 1e4, 1e17, 1e30, 1e74, 1e100, 1e150, 1e300, f64::MAX];

struct Dice(Random);

impl Dice {
    fn below(&mut self, count: usize) -> usize {
        ((self.0.number() + 1.0) / 2.0 * count as f64) as usize
    }

    /// Of both signs, sometimes not finite.
    fn number(&mut self) -> f64 {
        match self.below(20) {
            0 => f64::NAN,
            1 => f64::INFINITY,
            sign => SIZES[self.below(SIZES.len())] * if sign % 2 == 0 { 1.0 } else { -1.0 },
        }
    }

    fn size(&mut self) -> f64 {
        SIZES[self.below(SIZES.len())]
    }

    fn three(&mut self) -> [f64; 3] {
        [self.number(), self.number(), self.number()]
    }

    /// Options, a few of which are not those of the file.
    fn options(&mut self) -> SceneOptions {
        let mut options = SceneOptions::default();
        for _ in 0..self.below(3) {
            match self.below(7) {
                0 => options.time_step = Some(self.size()),
                1 => options.alpha = Some(self.size()),
                2 => options.beta = Some(self.size()),
                3 => options.density = self.size(),
                4 => options.stiffness = self.size(),
                5 => options.viscosity = self.size(),
                _ => options.structure = StructureChoice::Exact,
            }
        }
        options
    }
}

/// Everything that can be read of a body is finite.
fn all_finite<T: Scalar>(body: &Body<'_, T>, what: &str) {
    for quantity in Quantity::ALL {
        for field in [Field::Displacement, Field::Velocity] {
            for index in 0..body.count(quantity).min(4) {
                let mut out = vec![0.0; body.length(quantity)];
                let read = body.read(quantity, index, field, &mut out);
                assert!(
                    read.is_err() || out.iter().all(|x| x.is_finite()),
                    "{what}: {} {field:?}: {out:?}",
                    quantity.name()
                );
            }
        }
    }
}

/// Calls of all kinds on one body.
fn life<T: Scalar>(file: &File<'_>, dice: &mut Dice, name: &str) {
    let scene = dice.options();
    let options = BodyOptions { scene, places: 2, keep_loads: true, ..BodyOptions::default() };
    let what = format!("{name} {options:?}");
    let Ok(length) = Body::<T>::len_for(file, &options) else { return };
    let mut memory = vec![0.0; length];
    let Ok(mut body) = Body::<T>::bind(file, &options, &mut memory) else { return };
    let place = body.locate([0.1, 0.05, 0.0]).ok().map(|point| point.place);
    let r = body.scene().n_modes();
    for _ in 0..12 {
        let before = body.state().zeta().to_vec();
        let mut refused = false;
        match (dice.below(9), place) {
            (0, Some(place)) => {
                let _ = body.push(&place, dice.three());
            }
            (1, Some(place)) => {
                let _ = body.push_ramp(&place, dice.three(), dice.three());
            }
            (2, _) => {
                let _ = body.push_pattern(0, dice.number());
            }
            (3, _) => {
                let (acceleration, angular_velocity) = (dice.three(), dice.three());
                let motion = BaseMotion { acceleration, angular_velocity, ..BaseMotion::default() };
                let _ = body.push_base(&motion);
            }
            (4, _) => {
                let _ = body.throw(dice.three(), dice.three());
            }
            (5, _) => {
                let numbers = |dice: &mut Dice| (0..r).map(|_| dice.number()).collect::<Vec<_>>();
                let (zeta, rate) = (numbers(dice), numbers(dice));
                refused = body.set(&zeta, &rate).is_err();
            }
            (6, Some(place)) => {
                let weights = [dice.number(), dice.number(), dice.number()];
                let odd = Place::triangle([0, 1, 2], weights);
                for place in [place, odd] {
                    let (mut w, mut free) = ([0.0; 9], [[0.0; 3]]);
                    if body.compliance(&[place], &mut w).is_ok() {
                        assert!(w.iter().all(|x| x.is_finite()), "{what}: compliance {w:?}");
                    }
                    if body.free_motion(&[place], &mut free).is_ok() {
                        let finite = free.as_flattened().iter().all(|x| x.is_finite());
                        assert!(finite, "{what}: free motion {free:?}");
                    }
                }
            }
            (7, _) => {
                if body.rebind(&SceneOptions { structure: scene.structure, ..dice.options() }).is_ok() {
                    body.clear();
                }
            }
            _ => refused = body.step().is_err(),
        }
        if refused {
            assert_eq!(body.state().zeta(), before, "{what}: a refused call has changed the state");
            body.clear();
        }
        all_finite(&body, &what);
    }
}

#[test]
fn what_is_taken_gives_finite_numbers_and_what_is_refused_changes_nothing() {
    let mut dice = Dice(Random::new(43));
    for (name, bytes) in fixtures("golden") {
        let file = File::parse(&bytes).expect("a golden file");
        for _ in 0..1500 {
            life::<f64>(&file, &mut dice, &name);
            life::<f32>(&file, &mut dice, &name);
        }
    }
}

#[test]
fn parameters_beyond_the_precision_are_refused_by_name() {
    let (_, bytes) = fixtures("golden").into_iter().find(|(name, _)| name == "exact-f64.vdm").expect("there");
    let file = File::parse(&bytes).expect("a file");
    let asked = |edit: &dyn Fn(&mut SceneOptions)| {
        let mut options = SceneOptions::default();
        edit(&mut options);
        let sizes = Scene::<f32>::sizes(&file, &options).expect("sizes");
        let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
        Scene::<f32>::bind(&file, &options, &mut memory, &mut work)
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    type Change<'a> = &'a dyn Fn(&mut SceneOptions);
    let cases: [(Change<'_>, &str); 6] = [
        (&|options| options.time_step = Some(1e300), "time step"),
        (&|options| options.time_step = Some(1e-300), "time step"),
        (&|options| options.alpha = Some(1e300), "alpha"),
        (&|options| options.beta = Some(1e300), "beta"),
        (&|options| options.density = 1e300, "density scale"),
        (&|options| options.stiffness = 1e300, "stiffness scale"),
    ];
    for (edit, name) in cases {
        let refused = asked(edit).expect_err(name);
        assert!(refused.contains(name), "{name}: {refused}");
    }
    assert_eq!(asked(&|options| options.beta = Some(1e-300)), Ok(()));
    assert_eq!(Place::new(&[0, 1, 2], &[1.0, 1e300, -1e300]), Err(PlaceError::NotFinite));
}

#[test]
fn sizes_beyond_memory_are_refused_by_name_and_never_wrap_around() {
    let huge = [MAX_CONTACTS + 1, 1 << 31, usize::MAX / 12, usize::MAX / 4 + 1, usize::MAX - 1, usize::MAX];
    for (name, bytes) in fixtures("golden") {
        let file = File::parse(&bytes).expect("a golden file");
        let ordinary = BodyOptions::default();
        let Ok(least) = Body::<f64>::len_for(&file, &ordinary) else { continue };
        for asked in huge {
            let contacts = SceneOptions { contacts: asked, ..SceneOptions::default() };
            let refused = BindError::TooLarge { what: "contacts", asked, most: MAX_CONTACTS };
            assert_eq!(Scene::<f64>::sizes(&file, &contacts), Err(refused), "{name}");
            assert_eq!(Scene::<f32>::sizes(&file, &contacts), Err(refused), "{name}");
            let places = BodyOptions { places: asked, ..ordinary };
            let refused = BindError::TooLarge { what: "places", asked, most: MAX_CONTACTS };
            assert_eq!(Body::<f64>::len_for(&file, &places), Err(refused), "{name}");
            let filtered = SceneOptions { filtered_nodes: Some(asked), ..SceneOptions::default() };
            assert!(
                Scene::<f64>::sizes(&file, &filtered).is_ok(),
                "{name}: never more than the nodes there are"
            );
        }
        let most = BodyOptions {
            scene: SceneOptions { contacts: MAX_CONTACTS, ..SceneOptions::default() },
            places: MAX_CONTACTS,
            keep_loads: true,
            ..ordinary
        };
        assert!(Body::<f64>::len_for(&file, &most).expect(&name) > least, "{name}");
    }
}
