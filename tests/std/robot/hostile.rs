//! Files that mean harm, or that something has gnawed at: an error, at once, and no panic.

use super::valid::{VALID, read};
use crate::random::Random;
use std::time::{Duration, Instant};
use steadyarm::robot::{Description, GRAVITY};

/// Far more than a 16 MiB file takes on a slow machine, far less than work that grows with its
/// square.
const AT_ONCE: Duration = Duration::from_secs(20);

#[track_caller]
fn refused(text: &str, words: &[&str]) {
    let start = Instant::now();
    let message = read(text).unwrap_err().to_string();
    assert!(start.elapsed() < AT_ONCE);
    assert!(message.len() < 1000, "{} bytes", message.len());
    for word in words {
        assert!(message.contains(word), "{word:?} is not in: {message}");
    }
}

#[test]
fn document_types_are_refused() {
    let entities =
        "<?xml version=\"1.0\"?>\n<!DOCTYPE robot [<!ENTITY a \"aaaa\">]>\n<robot name=\"&a;\"/>";
    refused(entities, &["line 2", "document type"]);
    let external = "<!DOCTYPE robot SYSTEM \"file:///etc/passwd\"><robot/>";
    refused(external, &["line 1", "document type"]);
    refused("<robot><link name=\"&secret;\"/></robot>", &["line 1", "not well-formed"]);
}

#[test]
fn deep_nesting_is_refused() {
    for element in ["a", "link", "robot"] {
        let open = format!("<{element}>\n").repeat(200_000);
        refused(&format!("<robot>\n{open}"), &["line 65", "nested deeper than 64"]);
        let close = format!("</{element}>").repeat(200_000);
        refused(&format!("<robot>\n{open}{close}</robot>"), &["line 65", "nested deeper than 64"]);
    }
    // In quotes, comments and character data nothing nests.
    let flat = format!(
        "<robot name='{0}' ><!-- {1} --><![CDATA[{1}]]><link name=\"a\"/></robot>",
        ">".repeat(200),
        "<a>".repeat(200)
    );
    refused(&flat, &["joints", "none that moves"]);
}

#[test]
fn large_files_are_refused_before_they_are_read() {
    refused(
        &format!("<robot>{}</robot>", " ".repeat(64 << 20)),
        &["bytes", "wants at most 16777216"],
    );
    let path = std::env::temp_dir().join(format!("steadyarm-large-{}.urdf", std::process::id()));
    std::fs::File::create(&path).unwrap().set_len(64 << 20).unwrap();
    let error = Description::from_urdf_file(&path, None, None, GRAVITY).unwrap_err().to_string();
    std::fs::remove_file(&path).unwrap();
    assert!(error.contains("67108864 bytes") && error.contains("steadyarm-large"), "{error}");
}

#[test]
fn what_is_not_a_file_of_text_is_refused() {
    let read = |path: &std::path::Path| {
        Description::from_urdf_file(path, None, None, GRAVITY).unwrap_err().to_string()
    };
    assert!(read(&std::env::temp_dir()).contains("wants a file"));
    assert!(read("/no/such.urdf".as_ref()).contains("cannot be read"));
    #[cfg(unix)]
    assert!(read("/dev/zero".as_ref()).contains("wants a file"));
    let path = std::env::temp_dir().join(format!("steadyarm-bytes-{}.urdf", std::process::id()));
    std::fs::write(&path, b"\xff\xfe<\0r\0/\0>\0").unwrap();
    let message = read(&path);
    std::fs::remove_file(&path).unwrap();
    assert!(message.contains("UTF-16") && message.contains("steadyarm-bytes"), "{message}");
}

#[test]
fn many_of_anything_take_no_longer_than_the_file_is_long() {
    let many = |n: usize, piece: &dyn Fn(usize) -> String| (0..n).map(piece).collect::<String>();
    let attributes = many(500_000, &|i| format!(" a{i}=\"\""));
    refused(&format!("<robot{attributes}/>"), &["attributes"]);
    let spaces = many(100_000, &|i| format!("<a xmlns:n{i}=\"u{i}\"/>"));
    refused(&format!("<robot>{spaces}</robot>"), &["namespaces"]);
    let data = "x<![CDATA[y]]>".repeat(500_000);
    refused(&format!("<robot>{data}</robot>"), &["character data"]);
    refused(&format!("<robot>{}</robot>", "<a/>".repeat(3_000_000)), &["elements"]);
    let roots = many(100_000, &|i| format!("<link name=\"l{i}\"/>"));
    refused(&format!("<robot>{roots}</robot>"), &["100000 without a parent", "more"]);
    let names = many(100_000, &|i| format!("<e{i}/>"));
    let start = Instant::now();
    let notes = read(&VALID.replace("</robot>", &format!("{names}</robot>"))).unwrap().notes;
    assert!(start.elapsed() < AT_ONCE && notes.len() < 30);
    refused(
        &VALID.replace("\"tool\"", &format!("\"{}\"", "t".repeat(1 << 20))).replacen(
            "\"wrist\"",
            "\"\"",
            1,
        ),
        &["empty name"],
    );
}

/// Faults beside the chain are told, the first of them, without a look at the whole file for each.
#[test]
fn many_faults_beside_the_chain_take_no_longer_than_the_file_is_long() {
    let filler = " ".repeat(100);
    let link = |i: usize| format!("<link name=\"l{i}\"><inertial/>{filler}</link>");
    let joint = |i: usize| {
        format!(
            "<joint name=\"j{i}\" type=\"fixed\"><parent link=\"tool\"/><child link=\"l{i}\"/>\
             </joint>\n<joint name=\"j{i}\"/>\n<link name=\"tool\"/>"
        )
    };
    let parts: String = (0..18_000).map(|i| link(i) + &joint(i)).collect();
    let text = VALID.replace("</robot>", &format!("{parts}</robot>"));
    let start = Instant::now();
    let arm = Description::from_urdf(&text, None, Some("hand"), GRAVITY).unwrap();
    assert!(start.elapsed() < AT_ONCE && arm.notes.len() < 60);
    assert!(arm.notes.iter().any(|note| note.contains("further notes")), "{:?}", arm.notes);
    assert_eq!(arm.joints, read(VALID).unwrap().joints);
}

/// What the XML reader is not shown costs no more than what it is.
#[test]
fn comments_prefixes_and_declarations_are_passed_in_one_go() {
    let start = Instant::now();
    for piece in ["<!-- - -- -->", "<?a b?>", "<a:b c:d='e'/>", "<!---->"] {
        let many = piece.repeat(50_000);
        let text = VALID.replace("</robot>", &format!("{many}</robot>"));
        assert_eq!(read(&text).unwrap().joints.len(), 3);
    }
    for open in ["<!-- ", "<? ", "<a b:c='", "<![CDATA[", "</a:", "<a:b "] {
        let text = VALID.replace("</robot>", &open.repeat(1 << 20));
        refused(&text, &["line "]);
    }
    assert!(start.elapsed() < AT_ONCE);
}

#[test]
fn long_chains_are_read() {
    let n = 12_000;
    let inertial = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" \
                    ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
    let link = |i: usize| format!("<link name=\"l{i}\">{inertial}</link>");
    let joint = |i: usize| {
        format!(
            "<joint name=\"j{i}\" type=\"continuous\"><parent link=\"l{i}\"/>\
             <child link=\"l{}\"/></joint>",
            i + 1
        )
    };
    let parts: String = (0..n).map(|i| link(i) + &joint(i)).collect();
    let start = Instant::now();
    let arm = read(&format!("<robot>{parts}{}</robot>", link(n))).unwrap();
    assert!(start.elapsed() < AT_ONCE);
    assert_eq!(arm.joints.len(), n);
}

/// The valid file with a few bytes flipped, cut out or doubled.
fn mutated(random: &mut Random) -> Vec<u8> {
    let mut bytes = VALID.as_bytes().to_vec();
    let mut below = |n: usize| random.between(0.0, n as f64) as usize;
    for _ in 0..1 + below(4) {
        let (at, length) = (below(bytes.len()), below(40));
        let end = (at + length).min(bytes.len());
        match below(4) {
            0 => bytes[at] ^= 1 << below(8),
            1 => drop(bytes.drain(at..end)),
            2 => bytes.truncate(bytes.len() - length.min(bytes.len() - 1)),
            _ => {
                let piece = bytes[at..end].to_vec();
                let to = below(bytes.len());
                bytes.splice(to..to, piece);
            }
        }
    }
    bytes
}

#[test]
fn no_mutation_panics_or_hangs() {
    let mut random = Random(4);
    let (mut read_well, start) = (0, Instant::now());
    for _ in 0..2000 {
        let bytes = mutated(&mut random);
        if let Ok(arm) = read(&String::from_utf8_lossy(&bytes)) {
            read_well += 1;
            assert_eq!(Description::from_toml(&arm.to_toml()), Ok(arm));
        }
    }
    assert!(start.elapsed() < AT_ONCE);
    // Neither is everything refused, nor everything accepted.
    assert!((20..1500).contains(&read_well), "{read_well}");
}
