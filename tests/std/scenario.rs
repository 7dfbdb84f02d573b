//! Settings: the same from TOML and from Rust, what they build, and what they refuse by its path.

use steadyarm::control::{
    Adaptation, ComputedTorque, Controller, FuzzyCompensator, FuzzyParameters, Gains,
};
use steadyarm::math::Vector;
use steadyarm::paper;
use steadyarm::plant::{Disturbance, Noise};
use steadyarm::reference::{MotionLimits, Reference, Waypoints};
use steadyarm::robot::ReadError;
use steadyarm::scenario::{
    BasisSettings, CompensatorSettings, Curve, CurveSettings, MethodName, Numbers, QuinticSettings,
    Rules, RunSettings, Scenario, SinesSettings,
};
use steadyarm::sim::{Method, Options, Tolerance};

const PAPER: &str = "
[two_link]
mass = 4
length = [0.5, 0.5]
inertia = 0.2

[controller]
kp = 8.0
kv = 5.5

[compensator]
gain = [7, 7]

[compensator.basis]
form = \"grid\"
centers = [-1.5, -0.5, 0, 0.5, 1.5]
width = 0.7071067811865476
normalized = false

[reference.sines]
frequency = [1, 3]
sin = [[0, -0.2], [0.2, 0]]
cos = [[0.5, -0.5], [0, 0]]
";

fn paper_basis() -> BasisSettings {
    let centers = Numbers::from(paper::CENTERS);
    let basis = BasisSettings::new(Rules::Grid, centers, paper::WIDTH.into());
    BasisSettings { normalized: false, ..basis }
}

/// The numbers of the paper are typed once: what is named after them gives the core's own objects.
#[test]
fn the_papers_scenario_builds_the_papers_objects() {
    for reading in [paper::PRINTED, paper::CLAIMED] {
        let scenario = Scenario::paper(reading).unwrap();
        let text = scenario.to_toml().unwrap();
        let read = Scenario::from_toml(&text).unwrap();
        assert_eq!(read.to_toml().unwrap(), text);
        let Scenario { two_link, plant, compensator, .. } = &read;
        assert_eq!(two_link.as_ref().unwrap().build(), paper::nominal());
        assert_eq!(plant.as_ref().unwrap().build(), paper::actual());
        let Curve::Sines(sines) = read.reference::<2>().unwrap().unwrap() else { panic!() };
        assert_eq!(sines.harmonics(), paper::reference().unwrap().harmonics());
        let tau_d = read.disturbance::<2, _>(&paper::actual().unwrap()).unwrap();
        let same = |t: f64| tau_d.at_time(t) == paper::disturbance().unwrap().at_time(t);
        assert!((0..50).all(|k| same(0.3 * f64::from(k))));
        let parameters = compensator.as_ref().unwrap().parameters::<2>().unwrap();
        assert_eq!(parameters, *paper::controller(reading).unwrap().compensator.parameters());
    }
}

/// Every setting away from its default.
fn unusual() -> Scenario {
    let basis = BasisSettings {
        inputs: toml_inputs("{ dq = 0.5, q = 2.0 }"),
        ..BasisSettings::new(
            Rules::Grid,
            Numbers::Rows(vec![vec![-1.0, 0.1], vec![0.0], vec![1e-3, 3.0], vec![2.0]]),
            [1.0, 0.5, 0.25, 0.1].into(),
        )
    };
    let compensator = CompensatorSettings {
        q: [1.0, 2.0, 3.0, 4.0].into(),
        gain: [0.1, 0.7].into(),
        gamma: 2.5,
        leak_rate: 0.25,
        error_modification: 0.125,
        projection_radius: 60.0,
        dead_zone: 1e-3,
        normalization: 0.3,
        dictionary: Some(64),
        merge_tolerance: Some(0.01),
        ..CompensatorSettings::new(basis)
    };
    let quintic = QuinticSettings {
        start: [0.1, 0.2].into(),
        goal: 0.3.into(),
        duration: 1.5,
        start_time: 0.5,
    };
    let sines = SinesSettings {
        frequency: 2.0.into(),
        sin: Some(0.3.into()),
        cos: None,
        offset: [0.0, -1.0].into(),
        start_time: Some(0.25),
    };
    let run = RunSettings {
        duration: 2.0,
        dt: 0.5e-3,
        method: MethodName::Dp54,
        control_period: Some(2e-3),
        q0: [0.1, -0.1].into(),
        dq0: 0.2.into(),
        rtol: 1e-6,
        atol: 1e-7,
    };
    Scenario {
        run: Some(run),
        compensator: Some(compensator),
        reference: Some(CurveSettings::Quintic(quintic)),
        disturbance: Some(CurveSettings::Sines(sines).into()),
        ..Scenario::default()
    }
}

fn toml_inputs(inputs: &str) -> steadyarm::scenario::InputSettings {
    let basis = format!("form = \"grid\"\ncenters = [0]\nwidth = 1\ninputs = {inputs}");
    let scenario = Scenario::from_toml(&format!("[compensator.basis]\n{basis}"));
    scenario.unwrap().compensator.unwrap().basis.inputs
}

#[test]
fn a_file_of_the_papers_numbers_builds_the_papers_controller() {
    let scenario = Scenario::from_toml(PAPER).unwrap();
    let (arm, feedback) =
        (scenario.two_link.clone().unwrap(), scenario.controller.clone().unwrap());
    assert_eq!(arm.build().unwrap(), paper::nominal().unwrap());
    let gains: Gains<2> = feedback.gains().unwrap();
    assert_eq!(gains, paper::gains().unwrap());

    let settings = scenario.compensator.clone().unwrap();
    let of_rust =
        CompensatorSettings { gain: [7.0; 2].into(), ..CompensatorSettings::new(paper_basis()) };
    assert_eq!(settings, of_rust);
    let parameters: FuzzyParameters<2> = settings.parameters().unwrap();
    let adaptation = Adaptation { gain: [paper::CLAIMED.gain; 2], ..Default::default() };
    assert_eq!(parameters, FuzzyParameters { adaptation, ..Default::default() });

    let basis = settings.basis.build(2).unwrap();
    let compensator = FuzzyCompensator::new(basis, &gains, parameters).unwrap();
    let ours = Controller::new(ComputedTorque::new(arm.build().unwrap(), gains), compensator);
    let theirs = paper::controller(paper::CLAIMED).unwrap();
    assert_eq!(ours.compensator.weights_len(), theirs.compensator.weights_len());
    assert_eq!(ours.compensator.p(), theirs.compensator.p());

    let motion = scenario.reference::<2>().unwrap().unwrap();
    for t in [0.0, 0.3, 7.0] {
        assert_eq!(motion.at(t), paper::reference().unwrap().at(t));
    }
}

#[test]
fn what_is_written_is_read_to_the_bit() {
    for scenario in [Scenario::from_toml(PAPER).unwrap(), unusual().checked().unwrap()] {
        let text = scenario.to_toml().unwrap();
        assert_eq!(Scenario::from_toml(&text).unwrap(), scenario, "{text}");
    }
}

#[test]
fn what_is_said_of_a_run_becomes_its_options() {
    assert_eq!(RunSettings::default().options::<3>(), Ok(Options::default()));
    let options = unusual().run.unwrap().options::<2>().unwrap();
    let method = Method::Dp54(Tolerance { rtol: 1e-6, atol: 1e-7 });
    let (q0, dq0, control_period) = ([0.1, -0.1], [0.2; 2], Some(2e-3));
    let (duration, dt) = (2.0, 0.5e-3);
    let wanted = Options { duration, dt, method, control_period, q0, dq0, ..Options::default() };
    assert_eq!(options, wanted);
    assert_eq!(unusual().run.unwrap().options::<3>().unwrap_err().parameter(), "q0");
}

/// The sets see the signals in the order that is written, which no sorting of keys may change.
#[test]
fn signals_keep_their_order() {
    let names = |inputs: &str| -> Vec<(String, f64)> { toml_inputs(inputs).0 };
    let pair = |name: &str, scale| (name.to_owned(), scale);
    assert_eq!(names("{ q = 2.0, dq = 0.5 }"), [pair("q", 2.0), pair("dq", 0.5)]);
    assert_eq!(names("{ dq = 0.5, q = 2.0 }"), [pair("dq", 0.5), pair("q", 2.0)]);
    assert_eq!(names("[\"q\", \"e\"]"), [pair("q", 1.0), pair("e", 1.0)]);
    assert_eq!(names("\"state\""), [pair("q", 1.0), pair("dq", 1.0)]);
    assert_eq!(names("\"ddq_d\""), [pair("ddq_d", 1.0)]);
}

#[test]
fn lists_of_centres_say_the_joints_and_spell_out_the_gain() {
    let compensator = unusual().checked().unwrap().compensator.unwrap();
    assert_eq!(compensator.basis.joints, Some(2));
    let one = CompensatorSettings { q: 10.0.into(), gain: 3.0.into(), ..compensator };
    assert_eq!(one.checked().unwrap().gain, [3.0; 2].into());
}

const REFUSED: [(&str, &str); 22] = [
    ("[controller]\nkp = 8\nkv = [5.5, -1]", "controller.kv[1]: got -1, wants a number > 0"),
    ("[controller]\nkp = [8, 8]\nkv = [5, 5, 5]", "controller.kv: got 3 entries, wants 2"),
    ("[controller]\nkp = 8\nkv = 5\neffort_limit = 0", "controller.effort_limit: got 0, wants"),
    ("[controller]\nkp = 8", "line 1: controller: missing field `kv`"),
    ("[controller]\nkp = \"8\"\nkv = 5", "line 2: controller.kp: invalid type: string \"8\""),
    ("[controller]\nkp = [8, \"8\"]\nkv = 5", "line 2: controller.kp[1]: invalid type: string"),
    ("[controller]\nkp = [[8]]\nkv = 5", "line 2: controller.kp: got a list of lists, wants"),
    ("[two_link]\nmass = 0\nlength = 1\ninertia = 1", "two_link.mass[0]: got 0, wants"),
    (
        "[two_link]\nmass = 1\nlength = 1\ninertia = 1\ncoulomb = [0, -1]",
        "two_link.coulomb[1]: got -1, wants a number >= 0",
    ),
    ("[two_link]\nmass = [1, 1, 1]\nlength = 1\ninertia = 1", "two_link.mass: got 3 entries"),
    ("[compensator]\ngian = 1", "compensator.gian: unknown field `gian`, expected one of `basis`"),
    ("gain = 1", "gain: unknown field `gain`, expected one of `title`"),
    (
        "[reference.circle]\nradius = 1",
        "line 1: reference: unknown variant `circle`, expected one of",
    ),
    (
        "[reference.sines]\nfrequency = 1\nsin = [0, 1]\ncos = [0, 1, 2]",
        "reference.sines.cos: got 3 entries, wants 2",
    ),
    (
        "[reference.quintic]\nstart = true\ngoal = 1\nduration = 1",
        "reference.quintic.start: invalid",
    ),
    ("[reference", "line 1: scenario: "),
    ("GRID width = 0", "compensator.basis.width: got 0, wants widths > 0"),
    (
        "[compensator.basis]\nform = \"gird\"\ncenters = [0]\nwidth = 1",
        "line 2: compensator.basis.form: unknown variant `gird`, expected one of `grid`",
    ),
    (
        "GRID width = 1\ninputs = \"err\"",
        "compensator.basis.inputs: got \"err\", wants one of e, de",
    ),
    ("GRID width = 1\ninputs = [\"e\", \"e\"]", "compensator.basis.inputs[1]: got 1, wants each"),
    ("GRID width = 1\njoints = -1", "compensator.basis.joints: invalid value: integer `-1`"),
    ("GRID width = 1\nsigma = 1", "compensator.basis.sigma: unknown field `sigma`"),
];

#[test]
fn what_is_wrong_is_named_by_its_path() {
    let grid = "[compensator.basis]\nform = \"grid\"\ncenters = [0, 1]\n";
    let refused = REFUSED.map(|(text, message)| {
        let error = Scenario::from_toml(&text.replace("GRID ", grid)).unwrap_err().to_string();
        (error.contains(message), error, message)
    });
    let others: Vec<_> = refused.iter().filter(|(named, ..)| !named).collect();
    assert!(others.is_empty(), "{others:#?}");
}

#[test]
fn numbers_of_a_compensator_are_refused_by_their_path() {
    let cases = [
        ("gain = [1, -1]", "compensator.gain[1]: got -1, wants a number > 0"),
        ("gain = 0", "compensator.gain[0]: got 0, wants a number > 0"),
        ("gain = [1, nan]", "compensator.gain[1]: got NaN, wants a finite number"),
        ("q = [1, 1, 1, -1]", "compensator.q[3]: got -1, wants a number >= 0"),
        ("q = [1, 1, 1]", "compensator.q: got 3 entries, wants 4"),
        ("q = [1, 1]\ngain = [1, 1]", "compensator.q: got 2 entries, wants 4"),
        ("gamma = 0", "compensator.gamma: got 0, wants a number > 0, or infinity"),
        ("leak_rate = -1", "compensator.leak_rate: got -1, wants a number >= 0"),
        ("projection_radius = 0", "compensator.projection_radius: got 0, wants a radius"),
        ("dictionary = 0", "compensator.dictionary: got 0 entries, wants 1"),
        ("dictionary = 5000", "compensator.dictionary: got 5000, wants at most 4096"),
        ("merge_tolerance = 0.1", "compensator.merge_tolerance: got 0.1, wants a dictionary"),
        ("dictionary = 8\nmerge_tolerance = 1", "compensator.merge_tolerance: got 1, wants a part"),
        ("dead_zone = \"0\"", "compensator.dead_zone: invalid type: string \"0\""),
    ];
    for (text, message) in cases {
        let basis = "form = \"grid\"\ncenters = [0, 1]\nwidth = 1";
        let text = format!("[compensator]\n{text}\n[compensator.basis]\n{basis}");
        let error = Scenario::from_toml(&text).unwrap_err().to_string();
        assert!(error.contains(message), "{text}\n{error}");
    }
}

#[test]
fn a_basis_of_too_many_inputs_is_refused_before_it_takes_memory() {
    for joints in [33_i64, 1 << 32, i64::MAX] {
        let basis = "[compensator.basis]\nform = \"grid\"\ncenters = [0]\nwidth = 1";
        let text = format!("{basis}\njoints = {joints}");
        let error = Scenario::from_toml(&text).unwrap_err().to_string();
        let inputs = 2_u64.saturating_mul(joints as u64);
        let wanted = format!("compensator.basis.inputs: got {inputs}, wants at most 64");
        assert!(error.contains(&wanted), "{error}");
    }
}

#[test]
fn whatever_stands_at_a_key_is_read_or_refused() {
    let basis = "\n[compensator.basis]\nform = \"grid\"\ncenters = [0, 1]\nwidth = 1";
    let modified = "leak_rate = 0\ndead_zone = 0\ndictionary = 9\nmerge_tolerance = 0.1";
    let sections = [
        format!("[compensator]\nq = 1\ngain = 1\ngamma = 1\n{modified}{basis}"),
        format!("{basis}\nnormalized = true\ninputs = \"error\"\njoints = 2"),
        "[controller]\nkp = 1\nkv = 1\neffort_limit = 1\neffort_rate_limit = 1".into(),
        "[two_link]\nmass = 1\nlength = 1\ninertia = 1\ngravity = 1\ncoulomb = 1".into(),
        "[reference.sines]\nfrequency = [1]\nsin = [[1, 1]]\ncos = [[1, 1]]\noffset = 1".into(),
        "[reference.quintic]\nstart = 0\ngoal = 1\nduration = 1\nstart_time = 0".into(),
        "[disturbance.table]\nt = [0, 1]\nq = [[0], [1]]\ndq = [[0], [1]]\nddq = [[0], [1]]".into(),
    ];
    let values = "[] [[]] [[0.0],[]] [0.0] [[0.0],[1.0]] [[[1]]] 1 -1 0 nan inf 1e308 1e-320 \"a\" \
                  \"grid\" \"concat\" \"shared\" \"per_joint\" true [1,2,3] [[1,2],[3,4]] {} 13 \
                  9223372036854775807 {e=1.0} {e=0.0} [\"e\",\"de\"] [\"e\",\"e\"] 1000000";
    let (mut read, mut refused) = (0, 0);
    for section in &sections {
        assert!(Scenario::from_toml(section).is_ok(), "{section}");
        for (key, old) in section.lines().filter_map(|line| line.split_once(" = ")) {
            for value in values.split_whitespace() {
                let line = |value: &str| format!("\n{key} = {value}");
                let text = section.replacen(&line(old), &line(value), 1);
                *if Scenario::from_toml(&text).is_ok() { &mut read } else { &mut refused } += 1;
            }
        }
    }
    assert!(read > 100 && refused > 500, "{read} read, {refused} refused");
}

#[test]
fn a_motion_of_other_joints_is_refused_where_it_is_built() {
    let scenario = unusual();
    let error = scenario.reference::<3>().unwrap_err().to_string();
    assert_eq!(error, "reference.quintic.start: got 2 entries, wants 3");
    let arm = paper::nominal().unwrap();
    assert_eq!(scenario.disturbance::<2, _>(&arm).unwrap().len(), 1);
    let table = "[reference.table]\nt = [0, 1]\nq = [[0, 0], [1, inf]]";
    let error = Scenario::from_toml(table).unwrap().reference::<2>().unwrap_err().to_string();
    assert_eq!(error, "reference.table.q[1]: got inf, wants a finite number");
}

const WAYPOINTS: &str = "[reference.waypoints]\nposes = [[0, 0], [1, -0.5], [0.2, 0.3]]\n\
                         velocity = [1.0, 2]\nacceleration = 4\njerk = 40.0\n";

#[test]
fn waypoints_are_read_and_written() {
    let text = format!("{WAYPOINTS}pause = [0.5]\nstart_time = 1.0\n");
    let scenario = Scenario::from_toml(&text).unwrap();
    assert_eq!(Scenario::from_toml(&scenario.to_toml().unwrap()).unwrap(), scenario);
    let path = scenario.reference::<2>().unwrap().unwrap();
    let limits = MotionLimits { velocity: [1.0, 2.0], acceleration: [4.0; 2], jerk: [40.0; 2] };
    let poses = [[0.0, 0.0], [1.0, -0.5], [0.2, 0.3]];
    let direct = Waypoints::new(&poses, &limits, &[0.5], 1.0).unwrap();
    assert!((0..40).all(|k| path.at(0.1 * f64::from(k)) == direct.at(0.1 * f64::from(k))));
    let three = scenario.reference::<3>().unwrap_err().to_string();
    assert_eq!(three, "reference.waypoints.poses[0]: got 2 entries, wants 3");
}

#[test]
fn waypoints_are_refused_by_the_path_of_the_key() {
    for (line, words) in [
        ("pause = [0.5, 0.1]", "pause: got 2 entries, wants 1"),
        ("pause = [[0.5]]", "pause: got a list of lists, wants a number or a list of numbers"),
        ("start_time = nan", "start_time: got NaN, wants a finite number"),
        ("stop = 1", "stop: unknown field `stop`"),
    ] {
        let built = Scenario::from_toml(&format!("{WAYPOINTS}{line}\n"));
        let error = built.and_then(|scenario| scenario.reference::<2>()).unwrap_err().to_string();
        assert!(error.contains(&format!("reference.waypoints.{words}")), "{error}");
    }
    for (key, value, words) in [
        ("jerk = 40.0", "jerk = [1.0, 2.0, 3.0]", "jerk: got 3 entries, wants 2"),
        ("jerk = 40.0", "jerk = 0", "jerk[0]: got 0, wants a number > 0"),
        ("jerk = 40.0\n", "", ": missing field `jerk`"),
    ] {
        let built = Scenario::from_toml(&WAYPOINTS.replace(key, value));
        let error = built.and_then(|scenario| scenario.reference::<2>()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn disturbances_are_one_section_or_a_list_that_adds_up() {
    let arm = paper::nominal().unwrap();
    let push = |text: &str| -> Result<_, ReadError> {
        let scenario = Scenario::from_toml(text)?;
        assert_eq!(Scenario::from_toml(&scenario.to_toml()?)?, scenario);
        let list = scenario.disturbance::<2, _>(&arm)?;
        Ok(list.torque(&Vector::<2>::new(0.3, -0.4), &Vector::zeros(), 1.25))
    };
    let pulses = "disturbance.pulses]\ntime = [1.0, 1.2]\ntorque = [[1, 2], [3, 4]]\n\
                  duration = [0.1, inf]\n";
    let noise = "disturbance.noise]\ndeviation = [0.5, 0.2]\ncutoff = 5.0\nseed = 3\n";
    let wrench = "disturbance.wrench]\nforce = [0, -20, 0]\n";
    let alone = [pulses, noise, wrench].map(|text| push(&format!("[{text}")).unwrap());
    assert_eq!(alone[0], Vector::<2>::new(3.0, 4.0));
    assert_eq!(alone[1], Noise::new([0.5, 0.2], 5.0, 3).unwrap().value(1.25));
    let list = [pulses, noise, wrench].map(|text| format!("[[disturbance]]\n[{text}")).concat();
    assert!((push(&list).unwrap() - alone.iter().sum::<Vector<2>>()).amax() < 1e-14);
    let over = "[disturbance.wrench.curve.pulses]\ntime = 1.0\ntorque = [0, -20, 0, 0, 0, 0]\n";
    assert_eq!(push(over).unwrap(), alone[2]);
    for (text, words) in [
        (
            "[disturbance.noise]\ndeviation = 1\ncutoff = 0",
            "noise.cutoff: got 0, wants a number > 0",
        ),
        ("[disturbance.noise]\ncutoff = 1.0", "noise: missing field `deviation`"),
        ("[disturbance.pulses]\ntime = 1\ntorque = [1, 2]\nshape = \"saw\"", "pulses.shape: "),
        (
            "[disturbance.pulses]\ntime = 1\ntorque = [1, 2, 3]",
            "pulses.torque: got 3 entries, wants 2",
        ),
        ("[disturbance.wrench]\nforce = [1, 2]", "wrench.force: "),
        ("[disturbance.bump]\ntime = 1", ": unknown variant `bump`"),
        (
            "[disturbance.wrench]\nforce = [1, 2, 3]\ncurve.noise.deviation = 1\n\
          curve.noise.cutoff = 1",
            "wrench.curve: got 1, wants none beside force",
        ),
    ] {
        let error = push(text).unwrap_err().to_string();
        assert!(error.contains("disturbance") && error.contains(words), "{error}");
    }
    let second =
        format!("{list}[[disturbance]]\n[disturbance.noise]\ndeviation = 1\ncutoff = -1\n");
    let error = push(&second).unwrap_err().to_string();
    assert_eq!(error, "disturbance[3].noise.cutoff: got -1, wants a number > 0");
}
