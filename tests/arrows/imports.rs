//! Finds the imports between the files of a crate, parsed by syn.
//!
//! Imports are the leaves of `use` declarations, and paths in code that begin with `crate`, `self`, `super` or a child
//! module. Paths from `crate` are also found in the arguments and definitions of macros. A re-exported name belongs to
//! the file that defines it, as far as `use` declarations show. A name whose definition is not found belongs to the
//! module in which it was looked up. Code under `#[cfg(test)]` and `mod` declarations do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};
use syn::{Attribute, File, Item, ItemMod, ItemUse, Macro, UseTree, VisRestricted};

/// A module's path from the root of the crate.
type ModulePath = Vec<String>;

/// A module: a file, or an inline module in one.
#[derive(Default)]
struct Module {
    file: PathBuf,
    /// The names that it defines.
    defines: BTreeSet<String>,
    /// The names that it imports by `use`, with their paths.
    brings: BTreeMap<String, Vec<String>>,
    /// The paths of its glob imports.
    globs: Vec<Vec<String>>,
    /// All paths in its code, including those to its own items.
    paths: Vec<Vec<String>>,
}

/// The modules of a crate.
pub(crate) struct Source {
    modules: BTreeMap<ModulePath, Module>,
}

/// An import: the importing file, the file that it imports from, and the path in the code.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Import {
    pub(crate) from: String,
    pub(crate) to: String,
    pub(crate) path: String,
}

/// What a path refers to.
enum Target {
    Module(ModulePath),
    /// An item of this module.
    Item(ModulePath),
    /// Something outside the crate.
    Outside,
}

impl Source {
    /// Parses the crate with the root file `root`. `read` returns the text of a file, if it exists.
    pub(crate) fn read(root: &Path, read: &dyn Fn(&Path) -> Option<String>) -> Self {
        let mut source = Self { modules: BTreeMap::new() };
        let folder = root.parent().expect("a folder").to_owned();
        source.read_file(&Vec::new(), root, &folder, read);
        source
    }

    fn read_file(
        &mut self,
        module: &ModulePath,
        file: &Path,
        folder: &Path,
        read: &dyn Fn(&Path) -> Option<String>,
    ) {
        let text = read(file).unwrap_or_else(|| panic!("{} is missing", file.display()));
        let File { items, .. } = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        self.take_items(module, file, folder, &items, read);
    }

    /// Adds a module with its items. The files of its child modules are in `folder`.
    fn take_items(
        &mut self,
        module: &ModulePath,
        file: &Path,
        folder: &Path,
        items: &[Item],
        read: &dyn Fn(&Path) -> Option<String>,
    ) {
        let mut this = Module { file: file.to_owned(), ..Module::default() };
        for item in items.iter().filter(|item| !is_for_tests(attributes(item))) {
            if let Item::Mod(inner) = item {
                let name = inner.ident.to_string();
                let (mut path, below) = (module.clone(), folder.join(&name));
                path.push(name.clone());
                if let Some((_, items)) = &inner.content {
                    self.take_items(&path, file, &below, items, read);
                } else {
                    assert!(!has(&inner.attrs, "path"), "{}: #[path] of {name}", file.display());
                    let flat = folder.join(format!("{name}.rs"));
                    let inner = if read(&flat).is_some() { flat } else { below.join("mod.rs") };
                    self.read_file(&path, &inner, &below, read);
                }
                continue;
            }
            if let Some(name) = defined(item) {
                this.defines.insert(name);
            }
            Visitor(&mut this).visit_item(item);
        }
        self.modules.insert(module.clone(), this);
    }

    /// Resolves a path in the module `at`. `seen` holds the re-exports that are being followed, to detect loops.
    fn resolve(&self, at: &ModulePath, path: &[String], seen: &mut Vec<(ModulePath, String)>) -> Target {
        let mut module = at.clone();
        let mut rest = path;
        let mut is_anchored = false;
        while let Some((first, more)) = rest.split_first() {
            match first.as_str() {
                "crate" => module.clear(),
                "self" => {}
                "super" => drop(module.pop()),
                _ => break,
            }
            (rest, is_anchored) = (more, true);
        }
        while let Some((name, more)) = rest.split_first() {
            let mut below = module.clone();
            below.push(name.clone());
            if self.modules.contains_key(&below) {
                (module, rest, is_anchored) = (below, more, true);
                continue;
            }
            let Some(here) = self.modules.get(&module) else { return Target::Outside };
            if here.defines.contains(name) {
                return Target::Item(module);
            }
            let step = (module.clone(), name.clone());
            if seen.contains(&step) {
                return Target::Outside;
            }
            seen.push(step);
            let target = self.brought(&module, name, seen);
            seen.pop();
            match target {
                Some(Target::Module(brought)) => (module, rest, is_anchored) = (brought, more, true),
                Some(found) => return found,
                // The name is defined by a macro or in another crate.
                None if is_anchored => return Target::Item(module),
                None => return Target::Outside,
            }
        }
        Target::Module(module)
    }

    /// Resolves a name that the module `at` imports.
    fn brought(&self, at: &ModulePath, name: &str, seen: &mut Vec<(ModulePath, String)>) -> Option<Target> {
        let here = &self.modules[at];
        if let Some(path) = here.brings.get(name) {
            // `use name;` and `use name::...` of another crate would otherwise recurse.
            if path.first().is_some_and(|first| first == name) && !self.modules.contains_key(&join(at, name))
            {
                return Some(Target::Outside);
            }
            return Some(self.resolve(at, path, seen));
        }
        here.globs.iter().find_map(|glob| {
            let Target::Module(module) = self.resolve(at, glob, seen) else { return None };
            let from = &self.modules[&module];
            let has_it = from.defines.contains(name)
                || from.brings.contains_key(name)
                || self.modules.contains_key(&join(&module, name));
            (has_it && module != *at).then(|| self.resolve(&module, &[name.to_owned()], seen))
        })
    }

    /// All imports of one file from another.
    pub(crate) fn imports(&self) -> BTreeSet<Import> {
        let mut all = BTreeSet::new();
        for (at, module) in &self.modules {
            for path in &module.paths {
                let (Target::Module(to) | Target::Item(to)) = self.resolve(at, path, &mut Vec::new()) else {
                    continue;
                };
                let to = &self.modules[&to].file;
                if *to != module.file {
                    let name = |file: &Path| file.display().to_string();
                    let path = path.join("::");
                    all.insert(Import { from: name(&module.file), to: name(to), path });
                }
            }
        }
        all
    }
}

fn join(module: &ModulePath, name: &str) -> ModulePath {
    module.iter().cloned().chain([name.to_owned()]).collect()
}

/// Collects the paths of an item.
struct Visitor<'a>(&'a mut Module);

impl Visitor<'_> {
    /// Adds the leaves of a `use` declaration.
    fn take_tree(&mut self, prefix: &[String], tree: &UseTree) {
        let with = |name: String| prefix.iter().cloned().chain([name]).collect::<Vec<_>>();
        let (path, binds) = match tree {
            UseTree::Path(path) => return self.take_tree(&with(path.ident.to_string()), &path.tree),
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.take_tree(prefix, tree));
            }
            UseTree::Glob(_) => {
                self.0.globs.push(prefix.to_owned());
                return self.0.paths.push(prefix.to_owned());
            }
            UseTree::Name(name) if name.ident == "self" => {
                (prefix.to_owned(), prefix.last().cloned().unwrap_or_default())
            }
            UseTree::Name(name) => (with(name.ident.to_string()), name.ident.to_string()),
            UseTree::Rename(name) if name.ident == "self" => (prefix.to_owned(), name.rename.to_string()),
            UseTree::Rename(name) => (with(name.ident.to_string()), name.rename.to_string()),
        };
        self.0.brings.insert(binds, path.clone());
        self.0.paths.push(path);
    }
}

impl<'a> Visit<'a> for Visitor<'_> {
    fn visit_item_use(&mut self, item: &'a ItemUse) {
        if item.leading_colon.is_none() {
            self.take_tree(&[], &item.tree);
        }
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        if path.segments.len() > 1 && path.leading_colon.is_none() {
            self.0.paths.push(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, invoked: &'a Macro) {
        self.0.paths.extend(paths_of_tokens(&invoked.tokens.to_string()));
        visit::visit_macro(self, invoked);
    }

    // `pub(in path)` imports nothing.
    fn visit_vis_restricted(&mut self, _: &'a VisRestricted) {}

    // Modules inside functions do not count as modules of the crate.
    fn visit_item_mod(&mut self, _: &'a ItemMod) {}

    fn visit_item(&mut self, item: &'a Item) {
        if !is_for_tests(attributes(item)) {
            visit::visit_item(self, item);
        }
    }
}

/// The paths that begin with `crate` in the text of tokens, in which tokens are separated by spaces.
fn paths_of_tokens(tokens: &str) -> Vec<Vec<String>> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = Vec::new();
    for (start, _) in tokens.match_indices("crate") {
        let is_whole = !tokens[..start].ends_with(is_name);
        let mut path = vec!["crate".to_owned()];
        let mut rest = &tokens[start + "crate".len()..];
        while let Some(after) = rest.trim_start().strip_prefix("::") {
            let after = after.trim_start();
            let end = after.find(|c| !is_name(c)).unwrap_or(after.len());
            if end == 0 {
                break;
            }
            path.push(after[..end].to_owned());
            rest = &after[end..];
        }
        if is_whole && path.len() > 1 {
            found.push(path);
        }
    }
    found
}

/// The name that an item defines.
fn defined(item: &Item) -> Option<String> {
    let name = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(name.to_string())
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

fn has(attributes: &[Attribute], name: &str) -> bool {
    attributes.iter().any(|attribute| attribute.path().is_ident(name))
}

/// True of `#[test]`, `#[cfg(test)]` and `#[cfg(all(test, ...))]`.
fn is_for_tests(attributes: &[Attribute]) -> bool {
    let is_test = |attribute: &Attribute| {
        let mut found = false;
        if attribute.path().is_ident("cfg") {
            let parsed = attribute.parse_nested_meta(|meta| {
                if meta.path.is_ident("test") {
                    found = true;
                } else if meta.path.is_ident("all") {
                    meta.parse_nested_meta(|inner| {
                        found |= inner.path.is_ident("test");
                        skip(&inner)
                    })?;
                } else {
                    return skip(&meta);
                }
                Ok(())
            });
            parsed.unwrap_or_else(|e| panic!("a cfg that is not understood: {e}"));
        }
        found || attribute.path().is_ident("test")
    };
    attributes.iter().any(is_test)
}

/// Skips the arguments or the value after a name in an attribute.
fn skip(meta: &syn::meta::ParseNestedMeta) -> syn::Result<()> {
    if meta.input.peek(syn::token::Paren) {
        return meta.parse_nested_meta(|inner| skip(&inner));
    }
    if meta.input.peek(syn::Token![=]) {
        meta.value()?.parse::<syn::Lit>()?;
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The imports of a crate with the given files (name and text), one of which is `lib.rs`, as "a.rs -> b.rs by
    /// path".
    pub(crate) fn imports_of(files: &[(&str, &str)]) -> Vec<String> {
        let files: BTreeMap<PathBuf, String> =
            files.iter().map(|(name, text)| (Path::new("src").join(name), (*text).to_owned())).collect();
        let source = Source::read(Path::new("src/lib.rs"), &|file| files.get(file).cloned());
        let plain = |name: &str| name.strip_prefix("src/").unwrap().replace('\\', "/");
        let all = source.imports().into_iter();
        all.map(|Import { from, to, path }| format!("{} -> {} by {path}", plain(&from), plain(&to))).collect()
    }

    #[test]
    fn declarations_and_paths_are_imports() {
        let files = [
            ("lib.rs", "mod a; mod b; mod c;"),
            ("a.rs", "use crate::b::{B, deep::D}; pub struct A(B, D);"),
            ("b/mod.rs", "pub mod deep; pub struct B;"),
            ("b/deep.rs", "pub struct D; fn f() -> super::B { super::B }"),
            ("c.rs", "const C: crate::a::A = crate::a::A(crate::b::B, super::b::deep::D); use std::fmt;"),
        ];
        assert_eq!(
            imports_of(&files),
            [
                "a.rs -> b/deep.rs by crate::b::deep::D",
                "a.rs -> b/mod.rs by crate::b::B",
                "b/deep.rs -> b/mod.rs by super::B",
                "c.rs -> a.rs by crate::a::A",
                "c.rs -> b/deep.rs by super::b::deep::D",
                "c.rs -> b/mod.rs by crate::b::B",
            ]
        );
    }

    #[test]
    fn what_is_re_exported_belongs_to_where_it_is_defined() {
        let files = [
            ("lib.rs", "mod a; mod b; pub use b::B as Known;"),
            ("a.rs", "use crate::Known; use crate::b::{E, inner}; type A = (Known, E, inner::E);"),
            ("b/mod.rs", "mod inner; mod all; pub use inner::B; pub use all::*;"),
            ("b/inner.rs", "pub struct B;"),
            ("b/all.rs", "pub enum E { V }"),
        ];
        assert_eq!(
            imports_of(&files),
            [
                "a.rs -> b/all.rs by crate::b::E",
                "a.rs -> b/inner.rs by crate::Known",
                "a.rs -> b/inner.rs by crate::b::inner",
                "a.rs -> b/inner.rs by inner::E",
                "b/mod.rs -> b/all.rs by all",
                "b/mod.rs -> b/inner.rs by inner::B",
                "lib.rs -> b/inner.rs by b::B",
            ]
        );
    }

    #[test]
    fn macros_are_read() {
        let files = [
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "fn f() { assert!(crate::b::TRUE); } macro_rules! m { () => { $crate::b::g() } }"),
            ("b.rs", "pub const TRUE: bool = true; pub fn g() {}"),
        ];
        assert_eq!(imports_of(&files), ["a.rs -> b.rs by crate::b::TRUE", "a.rs -> b.rs by crate::b::g"]);
    }

    #[test]
    fn tests_and_other_crates_and_visibilities_do_not_count() {
        let files = [
            ("lib.rs", "mod a; mod b; #[cfg(test)] mod tests;"),
            (
                "a.rs",
                "use serde::b; pub(in crate::b) struct A;
                #[cfg(test)] mod tests { use crate::b::B; }
                #[cfg(all(test, unix))] use crate::b::C;
                #[cfg(all(unix, target_arch = \"x86_64\"))] use crate::b::D;
                #[cfg(not(test))] use crate::b::E;
                #[test] fn f() { crate::b::F; }",
            ),
            ("b.rs", ""),
        ];
        assert_eq!(imports_of(&files), ["a.rs -> b.rs by crate::b::D", "a.rs -> b.rs by crate::b::E"]);
    }
}
