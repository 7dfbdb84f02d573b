//! XML that urdfdom, MuJoCo and Drake read, whose readers know no namespaces and skip what they do
//! not use.

use super::valid::{VALID, read};
use steadyarm::robot::{Description, GRAVITY};

const DECLARATION: &str = "<?xml version=\"1.0\"?>\n";

/// Both read, and to the same arm.
#[track_caller]
fn same(text: &str) {
    let (got, wanted) = (read(text).unwrap(), read(VALID).unwrap());
    assert_eq!((got.name, got.joints, got.tip), (wanted.name, wanted.joints, wanted.tip));
}

/// What stands before `</robot>`.
fn with(addition: &str) -> String {
    VALID.replace("</robot>", &format!("{addition}</robot>"))
}

#[test]
fn prefixes_need_no_declaration() {
    same(&with(
        "<gazebo reference='hand'><sensor:camera name=\"c\"><x:y/></sensor:camera></gazebo>",
    ));
    same(
        &with("<controller:gazebo_ros_p3d controller:update_rate='1' a:b = \"<\"/>")
            .replace("\"<\"", "\"&lt;\""),
    );
    same(&VALID.replace("<robot name", "<robot a:b='>' xmlns:x='' xmlns=\"http://ros.org\" name"));
    same(
        &VALID.replace(
            "<visual/>",
            "<x:visual y:z=\"1\" y_z=\"2\" /><my:link my:name='a'></my:link>",
        ),
    );
}

/// Names with a prefix are other names: urdfdom asks for the whole name.
#[test]
fn element_with_a_prefix_is_another_element() {
    same(&with(
        "<x:link \
         name=\"tool\"/><x:joint/><x:transmission><motorInertia>9</motorInertia></x:transmission>",
    ));
    same(&VALID.replace("<mass value=\"5\"/>", "<mass value=\"5\"/><x:mass value=\"7\"/>"));
    same(&VALID.replace("<mass value=\"5\"/>", "<mass x:value=\"7\" value=\"5\"/>"));
    let error = read(&VALID.replace("robot", "urdf:robot")).unwrap_err().to_string();
    assert!(error.contains("\"urdf:robot\"") && error.contains("wants <robot>"), "{error}");
}

#[test]
fn names_of_unused_elements_are_told_as_they_are_written() {
    let notes = read(&with("<sensor:camera/>")).unwrap().notes;
    assert!(notes.iter().any(|note| note.starts_with("<sensor:camera> in line ")), "{notes:?}");
}

#[test]
fn declaration_may_stand_anywhere() {
    let text = VALID.strip_prefix(DECLARATION).unwrap();
    for before in ["\n", "  ", "\r\n\r\n", "<!-- made by hand -->\n", "\u{feff}", "\u{feff}\n", ""]
    {
        same(&format!("{before}{VALID}"));
        same(&format!("{before}<?xml version='1.0' encoding=\"utf-8\" ?>{text}"));
        same(&format!("{before}<?xml?>{text}"));
    }
    same(&VALID.replace("</robot>", "<?xml version=\"1.0\"?><?php <link> ?></robot>\n<?end?>"));
}

#[test]
fn comments_may_hold_anything_but_their_end() {
    for comment in [
        "<!-- a -- b -->",
        "<!------- title ------->",
        "<!--->-->",
        "<!---->",
        "<!-- <link name='x'> --->",
        "<!-- & &nbsp; \u{1} é < ]]> -->",
        "<!-- <!-- twice -->",
    ] {
        same(&with(comment));
        same(&format!("{VALID}{comment}"));
        same(&VALID.replacen("<link", &format!("{comment}<link"), 1));
        same(&VALID.replace("<motorInertia>", &format!("<motorInertia>{comment}")));
    }
    // In quotes and character data nothing is a comment.
    same(&with("<a b='<!--'/>").replace("'<!--'", "'&lt;!--'"));
    same(&with("<a><![CDATA[<!-- <?xml <b:c> ]]></a>"));
    same(&VALID.replace("<motorInertia>0.0002<", "<motorInertia><![CDATA[0.0002]]><"));
}

/// As urdfdom and MuJoCo do, whose readers know five entities and leave all others as they are.
#[test]
fn what_is_not_read_need_not_be_well_formed() {
    for odd in [
        "<gazebo a=\"R&D\" b='<'>&nbsp; \u{1} R & D ]]></gazebo>",
        "<material name='&grey;'><texture filename=\"a&b.png\"/></material>",
        "<gazebo a=\"1\"b=\"2\"/>",
        "<xacro:property name='a' value=\"${1 if x < 2 else 3 & 4}\"/>",
    ] {
        same(&with(odd));
        same(&VALID.replace("<visual/>", &format!("<visual>{odd}</visual>")));
    }
    same(&VALID.replace("foot.stl", "R&D/foot.stl"));
    same(&VALID.replace("<mass value=\"5\"/>", "<mass value=\"5\"/> & "));
    same(&VALID.replace("<type>", "<type a='&'> & "));
}

#[test]
fn what_is_read_must_be_well_formed() {
    for (old, new) in [
        ("\"tool\"", "\"t&ol\""),
        ("\"tool\"", "\"t<ol\""),
        ("\"tool\"", "\"&tool;\""),
        ("0.0002", "&small;"),
        ("0.0002", "0.0002 & 1"),
        ("lower=\"0\" ", "lower=\"0\""),
        ("</robot>", "</robot> & more"),
    ] {
        let error = read(&VALID.replace(old, new)).expect_err(new).to_string();
        assert!(error.contains("not well-formed"), "{new}: {error}");
    }
    // Known entities are what they mean.
    let named = VALID.replace("\"tool\"", "\"R&amp;D\"");
    assert!(Description::from_urdf(&named, None, Some("R&D"), GRAVITY).is_ok());
}

#[test]
fn line_ends_of_windows_are_read() {
    same(&VALID.replace('\n', "\r\n"));
}

/// What is cleaned keeps its place: lines in messages are those of the file.
#[test]
fn lines_of_messages_are_those_of_the_file() {
    let before = "\u{feff}\n\n<!-- a -- b\né\n-->\n";
    let text = format!(
        "{before}{}",
        VALID.replace("\"0.7\"", "\"seven\"").replace("<robot", "<robot a:b='\n'")
    );
    let line = 1 + text[..text.find("seven").unwrap()].matches('\n').count();
    assert_eq!(read(&text).unwrap_err().line, Some(line));
}

#[test]
fn what_is_not_well_formed_stays_refused() {
    for broken in [
        "<joint b:c=1/>",
        "<joint b:c/>",
        "<a b:c=\"1/>",
        "<a:b></a:c>",
        "<a:b></a_c>",
        "<a",
        "<!-- open",
        "<? open",
        "<a <!-- x --> b='1'/>",
        "<joint b='<'/>",
        "<joint name='1' name='2'/>",
        "<a:b>",
        "</a:b>",
        "<transmission><motorInertia>&x;</motorInertia></transmission>",
        "<!DOCTYPE r>",
        "<!ENTITY a 'b'>",
        "<![CDATA[",
    ] {
        let error = read(&with(broken)).expect_err(broken).to_string();
        assert!(error.contains("line ") || error.contains("document type"), "{broken}: {error}");
    }
}

fn file(name: &str, bytes: &[u8]) -> Description {
    let path = std::env::temp_dir().join(format!("steadyarm-{name}-{}.urdf", std::process::id()));
    std::fs::write(&path, bytes).unwrap();
    let read = Description::from_urdf_file(&path, None, None, GRAVITY);
    std::fs::remove_file(&path).unwrap();
    read.unwrap()
}

#[test]
fn bytes_that_are_not_utf8_are_latin1() {
    // é is one byte in Latin-1 and two in UTF-8.
    let text =
        VALID.replace("\"waist\"", "\"\u{e9}paule\"").replace("<robot", "<!-- \u{fc} -->\n<robot");
    let latin: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let arm = file("undeclared", &latin);
    assert_eq!(arm.joints[0].name, "\u{e9}paule");
    let note = arm.notes.last().unwrap();
    assert!(note.contains("first in line 2") && note.contains("Latin-1"), "{note}");
    let declared = DECLARATION.replace("\"?>", "\" encoding='ISO-8859-1'?>").into_bytes();
    let declared = file("declared", &[declared.as_slice(), &latin[DECLARATION.len()..]].concat());
    assert_eq!(declared.joints, arm.joints);
    assert!(!declared.notes.iter().any(|note| note.contains("Latin-1")), "{:?}", declared.notes);
    assert_eq!(file("utf8", text.as_bytes()).joints, arm.joints);
}

#[test]
fn leftover_definitions_of_xacro_are_skipped() {
    let space = " xmlns:xacro=\"http://www.ros.org/wiki/xacro\"";
    for leftover in [
        "<xacro:property name='width' value='${2*radius}'/>",
        "<xacro:arg name='prefix' default=''/>",
        "<xacro:macro name='leg' params='p'><link name='${p}leg'/><xacro:if \
         value='1'/></xacro:macro>",
        "<gazebo><xacro:include filename='x'/>${a}</gazebo>",
    ] {
        same(&with(leftover));
        same(&with(leftover).replace("<robot", &format!("<robot{space}")));
        same(&VALID.replace("<visual/>", &format!("<visual>{leftover}</visual>")));
    }
    let notes = read(&with("<xacro:property name='a' value='1'/>")).unwrap().notes;
    assert!(notes.iter().any(|note| note.starts_with("<xacro:property>")), "{notes:?}");
}

#[test]
fn what_xacro_would_put_into_the_chain_names_xacrodoc() {
    let broken = [
        with("<xacro:include filename=\"$(find arm)/gripper.xacro\"/>"),
        with("<xacro:gripper parent='tool'/>"),
        with("<xacro:if value='true'><link name='x'/></xacro:if>"),
        VALID.replace("<mass value=\"5\"/>", "<mass value=\"${m}\"/>"),
        VALID.replace("<inertial>", "<xacro:box m='1'/><inertial>"),
        VALID.replace("<mass value=\"5\"/>", "<xacro:mass value='1'/><mass value=\"5\"/>"),
        VALID.replace("<origin xyz=\"0 0 0.2\"", "<origin xyz=\"0 0 ${h}\""),
        VALID.replace("\"hand\"", "\"$(arg prefix)hand\""),
        "<robot><xacro:arg name='a'/></robot>".to_owned(),
        "<robot xmlns:xacro='x'><xacro:macro name='arm'><link name='a'/></xacro:macro></robot>"
            .to_owned(),
    ];
    for text in broken {
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains("pip install xacrodoc") && error.starts_with("line "), "{error}");
    }
}

/// Files as they are found, one of each kind; `benches/robot_files.py` reads them too.
#[test]
fn files_of_these_kinds_are_read() {
    let read = |name: &str| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/std/robot/files");
        Description::from_urdf_file(format!("{folder}/{name}.urdf"), None, None, GRAVITY).unwrap()
    };
    let rotors = read("rotors");
    let armatures: Vec<_> = rotors.joints.iter().map(|joint| joint.link.armature).collect();
    assert_eq!(armatures, [160.0 * 160.0 * 0.0001321; 2]);
    let odd = read("odd");
    assert_eq!(odd.joints[0].name, "\u{e9}paule");
    let masses: Vec<_> = odd.joints.iter().map(|joint| joint.link.inertia).collect();
    let same: Vec<_> = rotors.joints.iter().map(|joint| joint.link.inertia).collect();
    assert_eq!(masses, same);
    assert_eq!(read("massless").joints[0].link.inertia.mass, 0.0);
}
