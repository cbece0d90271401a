//! The check on small made-up crates: it must find what it looks for, and nothing else.

use super::source::Source;
use super::tree::Tree;
use super::{circles, order, out_of_order};

fn tree(files: &[(&str, &str)]) -> Tree {
    Tree::new(files.iter().copied()).expect("they are read")
}

fn circles_of(files: &[(&str, &str)]) -> Vec<String> {
    let edges = tree(files).edges();
    circles(&edges).iter().map(ToString::to_string).collect()
}

#[test]
fn two_files_that_import_each_other_are_a_circle_with_its_names() {
    let found = circles_of(&[
        ("lib.rs", "pub mod stage;"),
        (
            "stage/mod.rs",
            "mod config;\nmod friction;\nuse config::Config;\n",
        ),
        (
            "stage/config.rs",
            "use super::friction::{Law,\n    virgin};\npub struct Config;",
        ),
        (
            "stage/friction.rs",
            "use super::config::Config as C;\npub struct Law;",
        ),
    ]);
    let expected = [
        "stage/config.rs takes super::friction::Law: `config` from `friction`",
        "stage/config.rs takes super::friction::virgin: `config` from `friction`",
        "stage/friction.rs takes super::config::Config: `friction` from `config`",
    ];
    assert_eq!(found, expected);
}

#[test]
fn a_circle_of_three_rooms_through_files_deep_inside_and_through_what_a_parent_hands_on() {
    for hands_on in ["pub use c::deep::Thing;", "pub use c::deep::*;"] {
        let found = circles_of(&[
            ("lib.rs", hands_on),
            ("a/mod.rs", "mod inner;"),
            ("a/inner.rs", "use crate::{b, d};\nfn f() { b::g() }"),
            (
                "b.rs",
                "fn g(of: crate::Thing) { println!(\"{}\", crate::Thing::NAME) }",
            ),
            ("c/mod.rs", "pub mod deep;"),
            ("c/deep.rs", "use crate::a::inner;\npub struct Thing;"),
            // Beside it: what nothing is taken of, and what takes nothing.
            ("d.rs", ""),
            ("e.rs", "use crate::{a, d};"),
        ]);
        let expected = [
            "a/inner.rs takes crate::b: `a` from `b`",
            "b.rs takes crate::Thing: `b` from `c`",
            "b.rs takes crate::Thing::NAME: `b` from `c`",
            "c/deep.rs takes crate::a::inner: `c` from `a`",
        ];
        assert_eq!(found, expected);
    }
}

#[test]
fn what_a_parent_defines_tests_comments_and_texts_make_no_circle() {
    let found = circles_of(&[
        ("lib.rs", "pub mod a;\npub mod b;\npub struct Shared;"),
        (
            "a.rs",
            "use crate::{Shared, b::B};\nuse super::Shared as Same;\n// use crate::b::B;\npub struct A;",
        ),
        (
            "b.rs",
            "//! [`crate::a::A`]\nuse crate::Shared;\nconst TEXT: &str = \"use crate::a::A;\";\npub struct B;\n\
             #[cfg(test)]\nmod tests {\n    use crate::a::A;\n}\nmacro_rules! m { () => { $crate::a::A } }",
        ),
    ]);
    assert!(found.is_empty(), "{found:?}");
}

#[test]
fn trees_of_use_are_taken_apart() {
    let source = Source::read(
        "pub(crate) use a::{self, b::{C as D, e}, f::*,};\nfn x() -> impl Sized + use<'a> { reuse (1) }\n",
    );
    let imports = source.expect("it is read").imports.into_iter();
    let found: Vec<_> = imports.map(|i| (i.path.join("::"), i.alias)).collect();
    let expected = [
        ("a", "a"),
        ("a::b::C", "D"),
        ("a::b::e", "e"),
        ("a::f", "*"),
    ];
    assert_eq!(
        found,
        expected.map(|(path, alias)| (path.to_owned(), alias.to_owned()))
    );
}

#[test]
fn the_page_gives_the_order_and_each_breach_is_named() {
    let page = "…\n```text imports: src\nlow\nmid other — both rest on `low`\ngone\n```\n";
    let order = order(page, "src").expect("the block");
    let lines = [("gone", 2), ("low", 0), ("mid", 1), ("other", 1)];
    assert_eq!(order, lines.into());
    let tree = tree(&[
        ("lib.rs", ""),
        ("low.rs", "use crate::mid::M;"),
        ("mid.rs", "use crate::other::O;\npub struct M;"),
        ("other.rs", "pub struct O;"),
        ("new.rs", "use crate::low;"),
    ]);
    let wrong = out_of_order(&order, &tree, &tree.edges());
    let parts = [
        "names the room `new`",
        "names `gone`",
        "low.rs takes crate::mid::M",
        "mid.rs takes crate::other::O",
    ];
    assert_eq!(wrong.len(), parts.len(), "{wrong:?}");
    for (words, breach) in parts.iter().zip(&wrong) {
        assert!(breach.contains(words), "{words}: {breach}");
    }
}
