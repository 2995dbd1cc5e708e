//! Finds cycles in a directed graph.

use std::collections::{BTreeMap, BTreeSet};

/// The sets of two or more nodes that can all reach each other: the strongly connected components.
pub(crate) fn cycles(edges: &BTreeSet<(String, String)>) -> Vec<BTreeSet<String>> {
    let mut onward: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (from, to) in edges {
        onward.entry(from).or_default().push(to);
        onward.entry(to).or_default();
    }
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        onward.keys().map(|from| (*from, reachable(from, &onward))).collect();
    let mut all = BTreeSet::new();
    for (from, to) in &reached {
        let mutual = to.iter().filter(|other| reached[**other].contains(from));
        let set: BTreeSet<String> = mutual.map(|other| (*other).to_owned()).collect();
        if set.len() > 1 {
            all.insert(set);
        }
    }
    all.into_iter().collect()
}

/// The nodes that a node reaches by at least one edge.
fn reachable<'a>(from: &str, onward: &BTreeMap<&'a str, Vec<&'a str>>) -> BTreeSet<&'a str> {
    let (mut found, mut open) = (BTreeSet::new(), onward[from].clone());
    while let Some(node) = open.pop() {
        if found.insert(node) {
            open.extend(&onward[node]);
        }
    }
    found
}

#[test]
fn only_cycles_are_found() {
    let of = |edges: &[(&str, &str)]| {
        let edges = edges.iter().map(|(from, to)| ((*from).to_owned(), (*to).to_owned()));
        let sets = cycles(&edges.collect());
        sets.into_iter().map(|set| set.into_iter().collect::<Vec<_>>().join(" ")).collect::<Vec<_>>()
    };
    assert_eq!(of(&[("a", "b"), ("b", "c"), ("a", "c")]), [""; 0]);
    assert_eq!(of(&[("a", "a")]), [""; 0], "a file may name itself");
    assert_eq!(of(&[("a", "b"), ("b", "c"), ("c", "a"), ("c", "d")]), ["a b c"]);
    assert_eq!(of(&[("a", "b"), ("b", "a"), ("b", "c"), ("c", "d"), ("d", "c")]), ["a b", "c d"]);
}
