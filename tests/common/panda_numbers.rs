//! The joints and links of the Panda, for where there are no files; a test compares them with those
//! of the file.

use steadyarm::arm::{Inertia, JointFriction, JointKind, Link, Pose, Serial, SerialParameters};
use steadyarm::math::Matrix;

struct Numbers {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
    mass: f64,
    com: [f64; 3],
    moments: [[f64; 3]; 3],
    coulomb: [f64; 2],
    smoothing: f64,
}

pub fn panda() -> steadyarm::Result<Serial<7>> {
    let links = NUMBERS.map(|it| {
        let rows = |m: [[f64; 3]; 3]| Matrix::<3>::from_fn(|i, j| m[i][j]);
        let place = Pose { rotation: rows(it.rotation), translation: it.translation.into() };
        let inertia = Inertia { mass: it.mass, com: it.com.into(), moments: rows(it.moments) };
        let friction = JointFriction {
            coulomb: it.coulomb,
            smoothing: it.smoothing,
            ..JointFriction::default()
        };
        Link { friction, ..Link::new(JointKind::Revolute, place, [0.0, 0.0, 1.0].into(), inertia) }
    });
    Serial::new(SerialParameters { links, tip: Pose::IDENTITY, gravity: [0.0, 0.0, -9.81] })
}

const NUMBERS: [Numbers; 7] = [
    Numbers {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0, 0.0, 0.333],
        mass: 4.970684,
        com: [0.003875, 0.002081, 0.0],
        moments: [
            [0.70337, -0.000139, 0.006772],
            [-0.000139, 0.70661, 0.019169],
            [0.006772, 0.019169, 0.009117],
        ],
        coulomb: [0.24554270697694297, 0.30060729302305705],
        smoothing: 0.3907700123092554,
    },
    Numbers {
        rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
        translation: [0.0, 0.0, 0.0],
        mass: 0.646926,
        com: [-0.003141, -0.02872, 0.003495],
        moments: [
            [0.007962, -0.003925, 0.010254],
            [-0.003925, 0.02811, 0.000704],
            [0.010254, 0.000704, 0.025995],
        ],
        coulomb: [0.3851881977441091, 0.4870518022558909],
        smoothing: 0.2206117564004986,
    },
    Numbers {
        rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        translation: [0.0, -0.316, 0.0],
        mass: 3.228604,
        com: [0.027518, 0.039252, -0.066502],
        moments: [
            [0.037242, -0.004761, -0.011396],
            [-0.004761, 0.036155, -0.012805],
            [-0.011396, -0.012805, 0.01083],
        ],
        coulomb: [0.39380375457874867, 0.24687624542125136],
        smoothing: 0.1973164956590371,
    },
    Numbers {
        rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        translation: [0.0825, 0.0, 0.0],
        mass: 3.587895,
        com: [-0.05317, 0.104419, 0.027454],
        moments: [
            [0.025853, 0.007796, -0.001332],
            [0.007796, 0.019552, 0.008641],
            [-0.001332, 0.008641, 0.028323],
        ],
        coulomb: [0.575202938702743, 0.7041970612972571],
        smoothing: 0.3577625529935782,
    },
    Numbers {
        rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
        translation: [-0.0825, 0.384, 0.0],
        mass: 1.225946,
        com: [-0.011953, 0.041065, -0.038437],
        moments: [
            [0.035549, -0.002117, -0.004037],
            [-0.002117, 0.029474, 0.000229],
            [-0.004037, 0.000229, 0.008627],
        ],
        coulomb: [0.3737848087276591, 0.4652551912723409],
        smoothing: 0.2396099150582851,
    },
    Numbers {
        rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        translation: [0.0, 0.0, 0.0],
        mass: 1.666555,
        com: [0.060149, -0.014117, -0.010517],
        moments: [
            [0.001964, 0.000109, -0.001158],
            [0.000109, 0.004354, 0.000341],
            [-0.001158, 0.000341, 0.005433],
        ],
        coulomb: [0.1785290214018248, 0.12448097859817518],
        smoothing: 0.11673378859510886,
    },
    Numbers {
        rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        translation: [0.088, 0.0, 0.0],
        mass: 0.735522,
        com: [0.010517, -0.004252, 0.061597],
        moments: [
            [0.012516, -0.000428, -0.001196],
            [-0.000428, 0.010027, -0.000741],
            [-0.001196, -0.000741, 0.004815],
        ],
        coulomb: [0.277259938481679, 0.287630061518321],
        smoothing: 0.1934984520123839,
    },
];
