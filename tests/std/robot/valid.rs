//! One valid URDF of three joints, which the other tests break or extend, and what is read from it.

use steadyarm::arm::{JointFriction, JointKind};
use steadyarm::robot::{Description, GRAVITY, ReadError};

pub const VALID: &str = r#"<?xml version="1.0"?>
<robot name="three">
  <material name="grey"/>
  <link name="ground"/>
  <joint name="base" type="fixed">
    <origin xyz="0 0 0.1"/>
    <parent link="ground"/>
    <child link="foot"/>
  </joint>
  <link name="foot">
    <visual><geometry><mesh filename="/nowhere/foot.stl"/></geometry></visual>
  </link>
  <joint name="waist" type="revolute">
    <origin xyz="0 0 0.2" rpy="0 0 1.5707963267948966"/>
    <parent link="foot"/>
    <child link="trunk"/>
    <axis xyz="0 0 2"/>
    <limit lower="-1" upper="2" velocity="3" effort="40"/>
    <dynamics damping="0.5" friction="0.25"/>
  </joint>
  <link name="trunk">
    <inertial>
      <origin xyz="0.01 0.02 0.03"/>
      <mass value="5"/>
      <inertia ixx="0.3" ixy="0.01" ixz="0.02" iyy="0.4" iyz="0.03" izz="0.5"/>
    </inertial>
    <visual/>
  </link>
  <joint name="lift" type="prismatic">
    <origin xyz="0.1 0 0.5"/>
    <parent link="trunk"/>
    <child link="sled"/>
    <axis xyz="0 0 1"/>
    <limit lower="0" upper="0.7" velocity="0" effort="0"/>
  </joint>
  <link name="sled">
    <inertial>
      <mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/>
    </inertial>
  </link>
  <joint name="wrist" type="continuous">
    <origin xyz="0 0.3 0" rpy="0.1 0.2 0.3"/>
    <parent link="sled"/>
    <child link="hand"/>
    <axis xyz="0 1 0"/>
  </joint>
  <link name="hand">
    <inertial>
      <mass value="1"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
    </inertial>
  </link>
  <joint name="flange" type="fixed">
    <origin xyz="0 0 0.05"/>
    <parent link="hand"/>
    <child link="tool"/>
  </joint>
  <link name="tool"/>
  <transmission name="t">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="wrist"/>
    <actuator name="m">
      <mechanicalReduction>-50</mechanicalReduction>
      <motorInertia>0.0002</motorInertia>
    </actuator>
  </transmission>
</robot>
"#;

pub fn read(text: &str) -> Result<Description, ReadError> {
    Description::from_urdf(text, None, None, GRAVITY)
}

#[test]
fn chain_is_read_from_root_to_the_only_end() {
    let arm = read(VALID).unwrap();
    assert_eq!(arm.name, "three");
    let names: Vec<_> =
        arm.joints.iter().map(|j| (j.name.as_str(), j.link_name.as_str())).collect();
    assert_eq!(names, [("waist", "trunk"), ("lift", "sled"), ("wrist", "hand")]);
    let kinds: Vec<_> = arm.joints.iter().map(|joint| joint.link.kind).collect();
    assert_eq!(kinds, [JointKind::Revolute, JointKind::Prismatic, JointKind::Continuous]);
    assert_eq!(arm.gravity, GRAVITY);
    assert_eq!(arm.tip.translation.as_slice(), [0.0, 0.0, 0.05]);
}

#[test]
fn fixed_joint_before_the_first_is_part_of_its_placement() {
    let placement = read(VALID).unwrap().joints[0].link.placement;
    assert_eq!(placement.translation.as_slice(), [0.0, 0.0, 0.1 + 0.2]);
    // A quarter turn is exact: x becomes y.
    assert_eq!(placement.rotation.as_slice(), [0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn axis_is_brought_to_length_one() {
    assert_eq!(read(VALID).unwrap().joints[0].link.axis.as_slice(), [0.0, 0.0, 1.0]);
}

#[test]
fn roll_pitch_yaw_turn_about_the_fixed_axes_in_that_order() {
    let r = read(VALID).unwrap().joints[2].link.placement.rotation;
    let euler = nalgebra::Rotation3::from_euler_angles(0.1, 0.2, 0.3);
    assert!((r - euler.matrix()).amax() < 1e-15);
}

#[test]
fn limits_friction_and_rotor_are_read() {
    let arm = read(VALID).unwrap();
    let [waist, lift, wrist] = arm.links::<3>().unwrap();
    let limits = waist.limits;
    assert_eq!(
        [limits.lower, limits.upper, limits.velocity, limits.effort],
        [-1.0, 2.0, 3.0, 40.0]
    );
    let friction = JointFriction { viscous: 0.5, coulomb: [0.25; 2], ..Default::default() };
    assert_eq!(waist.friction, friction);
    assert_eq!([lift.limits.velocity, lift.limits.effort], [f64::INFINITY; 2]);
    assert_eq!([wrist.limits.lower, wrist.limits.upper], [f64::NEG_INFINITY, f64::INFINITY]);
    assert_eq!(lift.friction, JointFriction::default());
    assert_eq!([waist.armature, lift.armature, wrist.armature], [0.0, 0.0, 2500.0 * 0.0002]);
}

#[test]
fn mass_distribution_is_read() {
    let inertia = read(VALID).unwrap().joints[0].link.inertia;
    assert_eq!(inertia.mass, 5.0);
    assert_eq!(inertia.com.as_slice(), [0.01, 0.02, 0.03]);
    let moments = [0.3, 0.01, 0.02, 0.01, 0.4, 0.03, 0.02, 0.03, 0.5];
    assert_eq!(inertia.moments.as_slice(), moments);
}

#[test]
fn what_is_not_used_is_said_once() {
    let notes = read(VALID).unwrap().notes;
    let expected = [
        "joint \"lift\": <limit velocity=\"0\"> taken as no limit",
        "joint \"lift\": <limit effort=\"0\"> taken as no limit",
        "<material> in line 3: not used",
        "<visual>, 2 times, first in line 11: not used",
    ];
    assert_eq!(notes, expected);
}

#[test]
fn wrong_number_of_joints_says_both_numbers() {
    let message = read(VALID).unwrap().links::<6>().unwrap_err().to_string();
    assert!(message.contains("has 3") && message.contains("wants 6"), "{message}");
}

#[test]
fn file_is_read_as_its_text() {
    let path = std::env::temp_dir().join(format!("steadyarm-{}.urdf", std::process::id()));
    std::fs::write(&path, VALID).unwrap();
    let arm = Description::from_urdf_file(&path, None, None, GRAVITY);
    let broken = std::fs::write(&path, VALID.replace("0.7", "seven"));
    let error = Description::from_urdf_file(&path, None, None, GRAVITY).unwrap_err();
    std::fs::remove_file(&path).unwrap();
    broken.unwrap();
    assert_eq!(arm.unwrap(), read(VALID).unwrap());
    assert!(error.to_string().starts_with(&format!("{}, line 34: ", path.display())), "{error}");
}
