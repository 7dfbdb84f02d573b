//! Known names that resemble one that is not known.

use crate::robot::error::listed;

/// `; near are "a", "b"`: known names that resemble `name`, or else the first few.
pub(super) fn near<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    let lower = name.to_lowercase();
    let resembles = |other: &&str| {
        let other = other.to_lowercase();
        !lower.is_empty() && (other.contains(&lower) || lower.contains(&other))
            || distance(&lower, &other) <= 1 + lower.chars().count().min(24) / 4
    };
    let alike: Vec<_> = known.clone().filter(resembles).take(8).collect();
    match alike.is_empty() {
        false => format!("; near are {}", listed(alike.into_iter())),
        true => format!("; there are {}", listed(known.collect::<Vec<_>>().into_iter())),
    }
}

/// Levenshtein's distance of the first 32 characters.
fn distance(a: &str, b: &str) -> usize {
    const COMPARED: usize = 32;
    let b: Vec<char> = b.chars().take(COMPARED).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().take(COMPARED).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row.last().copied().unwrap_or(0)
}
