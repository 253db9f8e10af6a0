//! The tool of the page, natively: a sphere that is laid on a body, pressed in, dragged over it and taken
//! away neither enters the body nor gives it energy, in both precisions and beside other loads.

use std::sync::OnceLock;

use vademecum_eval::format::File;
use vademecum_eval::{Contact, Place, Scalar, SceneOptions, StructureChoice};
use vademecum_tests::exact_beam::exact_beam;
use vademecum_web::refusal::Refusal;
use vademecum_web::session::{Player, Session, lengths};
use vademecum_web::tool::Sphere;

const RADIUS: f64 = 0.03;
const TOP: f64 = 0.1;

/// A short undamped beam that a tool can be laid on.
fn beam() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(exact_beam)
}

fn with_session<T: Scalar>(options: &SceneOptions, act: impl FnOnce(&mut Session<'_, T>)) {
    let file = File::parse(beam()).expect("a file");
    let (body, field) = lengths::<T>(&file, options).expect("lengths");
    let (mut memory, mut field) = (vec![0.0; body], vec![T::ZERO; field]);
    let mut session = Session::bind(&file, options, &mut memory, &mut field).expect("a session");
    act(&mut session);
}

fn undamped() -> SceneOptions {
    SceneOptions { alpha: Some(0.0), beta: Some(0.0), ..SceneOptions::default() }
}

fn sphere(centre: [f64; 3]) -> Sphere {
    Sphere { radius: RADIUS, friction: 0.3, centre, target: centre, speed: 0.1, most: f64::INFINITY }
}

/// Lays it on, presses it in, drags it to the tip, and lifts it: the greatest depth, push and friction.
fn pressed<T: Scalar>(bound: f64, besides: Option<&Contact>) {
    with_session::<T>(&undamped(), |session| {
        if let Some(contact) = besides {
            session.add_contact(contact).expect("a contact");
        }
        let above = |x: f64, height: f64| [x, 0.03, TOP + RADIUS + height];
        session.hold(Some(sphere(above(0.6, 1e-3)))).expect("exact steps");
        let (mut deepest, mut hardest, mut rubbed) = (f64::NEG_INFINITY, 0.0_f64, 0.0_f64);
        for (target, steps) in [(above(0.6, -2e-3), 60), (above(0.8, -2e-3), 2010), (above(0.8, 0.05), 600)] {
            session.tool().expect("a tool").sphere.target = target;
            for _ in 0..steps {
                session.march(1, &mut []).expect("a step");
                let tool = session.tool().expect("a tool");
                assert!(tool.is_solved());
                deepest = deepest.max(tool.deepest() / RADIUS);
                for touch in tool.touches() {
                    let [x, y, z] = touch.force;
                    hardest = hardest.max(-z);
                    rubbed = rubbed.max((x * x + y * y).sqrt());
                }
            }
            assert_eq!(session.tool().expect("a tool").sphere.centre, target, "it arrives");
        }
        println!("deepest {deepest:.1e} of the radius, hardest {hardest:.1} N, across {rubbed:.2} N");
        assert!(deepest <= bound, "{deepest:e}");
        assert!(
            deepest >= -1e-6 && hardest > 1.0 && rubbed > 0.1,
            "it touches: {deepest:e} {hardest} {rubbed}"
        );

        // Lifted: no push is left, and what the body has of energy it keeps.
        let touches = session.tool().expect("a tool").touches();
        assert!(touches.iter().all(|touch| touch.force == [0.0; 3]), "5 cm above the beam");
        session.hold(None).expect("taken away");
        session.clear_loads();
        session.march(1, &mut []).expect("a step");
        let left = session.energy().expect("an energy");
        assert!(left > 0.0);
        for _ in 0..500 {
            session.march(1, &mut []).expect("a step");
            let energy = session.energy().expect("an energy");
            // A step rounds every coordinate once or twice.
            assert!(energy <= left * (1.0 + 2000.0 * T::EPSILON), "{energy} after {left}");
        }
    });
}

#[test]
fn a_tool_neither_enters_the_body_nor_gives_it_energy() {
    pressed::<f64>(1e-6, None);
}

#[test]
fn nor_does_it_beside_another_load() {
    let contact = Contact::new(Place::triangle([0, 1, 2], [0.25, 0.25, 0.5]), [1.0, -2.0, -5.0]);
    pressed::<f64>(1e-6, Some(&contact));
}

#[test]
fn in_single_precision_it_is_as_deep_as_rounding_makes_it() {
    // The place lies 10 radii from the origin and is moved in binary32: 1e-7 of what it moves.
    pressed::<f32>(1e-6, None);
}

#[test]
fn a_body_that_moves_by_stages_has_no_tool() {
    let options = SceneOptions { structure: StructureChoice::Diagonal, ..undamped() };
    let file = File::parse(beam()).expect("a file");
    // The structure that moves by stages is not in a file of exact steps; golden files have it.
    assert!(lengths::<f64>(&file, &options).is_err());
    let (_, bytes) =
        vademecum_tests::golden::all().into_iter().find(|(name, _)| *name == "fixed-f64.vdm").unwrap();
    let file = File::parse(&bytes).expect("a file");
    let (numbers, work) = lengths::<f64>(&file, &SceneOptions::default()).expect("lengths");
    let (mut memory, mut work) = (vec![0.0; numbers], vec![0.0; work]);
    let mut session =
        Session::bind(&file, &SceneOptions::default(), &mut memory, &mut work).expect("a session");
    let refusal = session.hold(Some(sphere([0.0; 3]))).expect_err("no tool");
    assert!(matches!(refusal, Refusal::NoTool) && refusal.to_string().contains("exact"), "{refusal}");
}

#[test]
fn it_stops_where_the_supports_hold_the_body_and_where_it_would_push_too_hard() {
    with_session::<f64>(&undamped(), |session| {
        // Over the held end, and over the middle with less force than the target takes.
        for (x, most) in [(0.0, f64::INFINITY), (0.5, 500.0)] {
            session.rest();
            let above = |height: f64| [x, 0.0, TOP + RADIUS + height];
            session
                .hold(Some(Sphere { most, target: above(-0.01), ..sphere(above(1e-3)) }))
                .expect("laid down");
            let (mut deepest, mut hardest) = (f64::NEG_INFINITY, 0.0_f64);
            for _ in 0..400 {
                session.march(1, &mut []).expect("a step");
                let tool = session.tool().expect("a tool");
                deepest = deepest.max(tool.deepest() / RADIUS);
                hardest = hardest.max(tool.touches().iter().map(|t| -t.force[2]).fold(0.0, f64::max));
            }
            let height = session.tool().expect("a tool").sphere.centre[2] - RADIUS - TOP;
            println!("at {x}: stopped at {height:.2e} m, hardest {hardest:.1} N, deepest {deepest:.1e}");
            assert!(deepest <= 1e-6, "{deepest:e}");
            // It came down onto the beam, and no further than the beam gives way under that force.
            assert!(height < 1e-4 && height > -5e-3, "{height}");
            // The body swings under a sphere that stays: twice the force it was stopped with.
            assert!(hardest <= 2.0 * most, "{hardest}");
            // It follows again where it is let.
            session.tool().expect("a tool").sphere.target = above(5e-3);
            session.march(400, &mut []).expect("steps");
            assert_eq!(session.tool().expect("a tool").sphere.centre, above(5e-3));
        }
    });
}

#[test]
fn a_sphere_without_a_size_is_refused() {
    with_session::<f64>(&undamped(), |session| {
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let found = session.hold(Some(Sphere { radius, ..sphere([0.0; 3]) }));
            assert!(matches!(found, Err(Refusal::BadTool)), "{radius}");
        }
        assert!(session.tool().is_none());
    });
}
