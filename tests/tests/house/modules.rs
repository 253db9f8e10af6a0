//! Which file of a crate uses which, from its `use` lines and from all other paths.
//!
//! A path leads to the file in which the item it names is defined: re-exports are followed, and a re-export
//! alone is no use. Also read are paths inside macro calls and in strings of attributes
//! (`#[serde(with = "crate::…")]`). Code for tests does not count. Not seen are uses without a path: a method
//! or a field of a value that came from elsewhere.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::sources::is_test_file;
use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};

/// A path in a program, segment by segment, as written or from the root of the crate.
type Segments = Vec<String>;

/// A use of one file by another: where, and the line.
#[derive(Clone)]
pub struct Use {
    /// File and line.
    pub place: String,
    pub text: String,
}

/// Files of a crate and what they use: `uses[from][to]`, paths below the `src` of the crate.
#[derive(Default)]
pub struct Graph {
    pub uses: BTreeMap<String, BTreeMap<String, Use>>,
}

#[derive(Default)]
struct Module {
    file: String,
    children: BTreeSet<String>,
    items: BTreeSet<String>,
    /// Imported names; functions may import different things under one name.
    names: BTreeMap<String, Vec<Segments>>,
    globs: Vec<Segments>,
    /// Paths that are used.
    mentions: Vec<Mention>,
}

struct Mention {
    path: Segments,
    line: usize,
    /// A module counts as used itself; elsewhere only what is in it does.
    modules: bool,
}

struct Crate {
    modules: BTreeMap<Segments, Module>,
    texts: BTreeMap<String, Vec<String>>,
}

/// What a path leads to.
enum Target {
    Module(Segments),
    /// An item, defined in this module.
    Item(Segments),
}

/// Reads the crate whose sources lie in this folder.
pub fn graph(source: &Path) -> Graph {
    let root = ["lib.rs", "main.rs"].into_iter().find(|name| source.join(name).is_file());
    let root = root.unwrap_or_else(|| panic!("{}: neither lib.rs nor main.rs", source.display()));
    let mut whole = Crate { modules: BTreeMap::new(), texts: BTreeMap::new() };
    whole.read(source, root, vec![]);
    whole.graph()
}

impl Crate {
    fn read(&mut self, source: &Path, file: &str, module: Segments) {
        let text = std::fs::read_to_string(source.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
        let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{file}: {e}"));
        self.texts.insert(file.to_string(), text.lines().map(str::to_string).collect());
        self.items(source, file, module, &parsed.items);
    }

    /// Takes the items of a module in `file`; a module with a file of its own is read from there.
    fn items(&mut self, source: &Path, file: &str, module: Segments, items: &[syn::Item]) {
        let mut reader = Reader { module: Module { file: file.to_string(), ..Module::default() } };
        for item in items {
            let syn::Item::Mod(child) = item else {
                reader.visit_item(item);
                continue;
            };
            if is_test(&child.attrs) {
                continue;
            }
            let name = child.ident.to_string();
            reader.module.children.insert(name.clone());
            let mut path = module.clone();
            path.push(name);
            match &child.content {
                Some((_, items)) => self.items(source, file, path, items),
                None => {
                    let stem = path.join("/");
                    let place = [format!("{stem}.rs"), format!("{stem}/mod.rs")];
                    let place = place.iter().find(|place| source.join(place).is_file());
                    self.read(source, place.unwrap_or_else(|| panic!("{file}: no file of {stem}")), path);
                }
            }
        }
        self.modules.insert(module, reader.module);
    }

    fn graph(&self) -> Graph {
        let mut graph = Graph::default();
        for (path, module) in self.modules.iter().filter(|(_, module)| !is_test_file(&module.file)) {
            graph.uses.entry(module.file.clone()).or_default();
            let globs = module.globs.iter().filter_map(|glob| match self.resolve(path, glob, 0)? {
                Target::Module(target) | Target::Item(target) => Some((target, 0)),
            });
            let mentions =
                module.mentions.iter().filter_map(|mention| match self.resolve(path, &mention.path, 0)? {
                    Target::Module(_) if !mention.modules => None,
                    Target::Module(target) | Target::Item(target) => Some((target, mention.line)),
                });
            for (target, line) in mentions.chain(globs) {
                let to = &self.modules[&target].file;
                if *to != module.file {
                    let text = self.texts[&module.file].get(line.wrapping_sub(1));
                    let text = text.map_or("a glob import", |text| text.trim()).to_string();
                    let uses = graph.uses.entry(module.file.clone()).or_default();
                    uses.entry(to.clone())
                        .or_insert_with(|| Use { place: format!("{}:{line}", module.file), text });
                }
            }
        }
        graph
    }

    /// Follows a path written in a module; `None` for what is not of this crate.
    fn resolve(&self, from: &Segments, path: &[String], depth: usize) -> Option<Target> {
        // A name may be imported through several modules, but not through itself.
        if depth > 20 {
            return None;
        }
        let module = &self.modules[from];
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => self.walk(&vec![], rest, depth),
            "self" => self.walk(from, rest, depth),
            "super" => self.walk_or_up(&from[..from.len().checked_sub(1)?].to_vec(), rest, depth),
            name if module.children.contains(name) && !rest.is_empty() => self.walk(from, path, depth),
            name if module.names.contains_key(name) => self.import(from, path, depth),
            name if module.children.contains(name) => self.walk(from, path, depth),
            name if module.items.contains(name) => Some(Target::Item(from.clone())),
            _ => self.through_globs(from, path, depth),
        }
    }

    fn walk_or_up(&self, module: &Segments, path: &[String], depth: usize) -> Option<Target> {
        match path.split_first() {
            Some((first, rest)) if first == "super" => {
                self.walk_or_up(&module[..module.len().checked_sub(1)?].to_vec(), rest, depth)
            }
            _ => self.walk(module, path, depth),
        }
    }

    /// Goes down from a module by names.
    fn walk(&self, at: &Segments, path: &[String], depth: usize) -> Option<Target> {
        let Some((first, rest)) = path.split_first() else { return Some(Target::Module(at.clone())) };
        let module = self.modules.get(at)?;
        let is_child = module.children.contains(first);
        if is_child && (!rest.is_empty() || !module.names.contains_key(first)) {
            let mut child = at.clone();
            child.push(first.clone());
            return self.walk(&child, rest, depth);
        }
        if module.names.contains_key(first) {
            return self.import(at, path, depth);
        }
        if module.items.contains(first) {
            return Some(Target::Item(at.clone()));
        }
        self.through_globs(at, path, depth).or_else(|| Some(Target::Item(at.clone())))
    }

    /// Follows the imports of the first name of `path`.
    fn import(&self, at: &Segments, path: &[String], depth: usize) -> Option<Target> {
        let (first, rest) = path.split_first()?;
        self.modules[at].names[first].iter().find_map(|target| {
            // `use block::block` in a module with a child `block` is no loop; `use x::y as x` is.
            match self.resolve(at, target, depth + 1)? {
                Target::Module(module) => self.walk(&module, rest, depth + 1),
                item => Some(item),
            }
        })
    }

    fn through_globs(&self, at: &Segments, path: &[String], depth: usize) -> Option<Target> {
        let first = path.first()?;
        let module = &self.modules[at];
        // The path of a glob begins with a name of the crate: through globs again, two of other crates would
        // be followed in every order.
        let is_own = |glob: &&Segments| {
            glob.first().is_some_and(|name| {
                ["crate", "self", "super"].contains(&name.as_str())
                    || module.children.contains(name)
                    || module.names.contains_key(name)
            })
        };
        module.globs.iter().filter(is_own).find_map(|glob| {
            let Target::Module(module) = self.resolve(at, glob, depth + 1)? else { return None };
            let there = &self.modules[&module];
            let known = there.items.contains(first)
                || there.children.contains(first)
                || there.names.contains_key(first);
            if known { self.walk(&module, path, depth + 1) } else { None }
        })
    }
}

/// Fills in a module from its items.
struct Reader {
    module: Module,
}

impl Reader {
    fn mention(&mut self, path: Segments, line: usize) {
        self.module.mentions.push(Mention { path, line, modules: false });
    }

    fn imports(&mut self, tree: &syn::UseTree, mut path: Segments, public: bool) {
        match tree {
            syn::UseTree::Path(next) => {
                path.push(next.ident.to_string());
                self.imports(&next.tree, path, public);
            }
            syn::UseTree::Name(name) => self.import(&name.ident, &name.ident, path, public),
            syn::UseTree::Rename(name) => self.import(&name.ident, &name.rename, path, public),
            syn::UseTree::Glob(_) => self.module.globs.push(path),
            syn::UseTree::Group(group) => {
                group.items.iter().for_each(|tree| self.imports(tree, path.clone(), public));
            }
        }
    }

    fn import(&mut self, original: &syn::Ident, name: &syn::Ident, mut path: Segments, public: bool) {
        let mut name = name.to_string();
        if original == "self" {
            if name == "self" {
                name = path.last().cloned().unwrap_or_default();
            }
        } else {
            path.push(original.to_string());
        }
        // A re-export is a use only where the file itself names it.
        if !public {
            self.mention(path.clone(), original.span().start().line);
        }
        self.module.names.entry(name).or_default().push(path);
    }

    /// Paths of at least two segments in a macro call.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Segments = vec![];
        let (mut line, mut colons) = (0, 0);
        for token in tokens {
            match &token {
                TokenTree::Ident(name) => {
                    if colons != 2 {
                        self.finish(&mut path, line);
                        line = name.span().start().line;
                    }
                    path.push(name.to_string());
                    colons = 0;
                    continue;
                }
                TokenTree::Punct(mark) if mark.as_char() == ':' => {
                    colons += 1;
                    continue;
                }
                TokenTree::Group(group) => self.tokens(group.stream()),
                _ => {}
            }
            self.finish(&mut path, line);
            colons = 0;
        }
        self.finish(&mut path, line);
    }

    fn finish(&mut self, path: &mut Segments, line: usize) {
        if path.len() > 1 {
            self.mention(path.clone(), line);
        }
        path.clear();
    }
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        let (attributes, name) = about(item);
        if is_test(attributes) {
            return;
        }
        self.module.items.extend(name.map(ToString::to_string));
        visit::visit_item(self, item);
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if item.leading_colon.is_none() {
            self.imports(&item.tree, vec![], !matches!(item.vis, syn::Visibility::Inherited));
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        if !is_test(&function.attrs) {
            visit::visit_impl_item_fn(self, function);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.leading_colon.is_none() {
            let segments = path.segments.iter().map(|s| s.ident.to_string()).collect();
            self.mention(segments, path.segments[0].ident.span().start().line);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.tokens(call.tokens.clone());
        visit::visit_macro(self, call);
    }

    fn visit_attribute(&mut self, attribute: &'ast syn::Attribute) {
        let syn::Meta::List(list) = &attribute.meta else { return };
        for token in list.tokens.clone() {
            let TokenTree::Literal(literal) = token else { continue };
            let line = literal.span().start().line;
            let Ok(text) = syn::parse_str::<syn::LitStr>(&literal.to_string()) else { continue };
            if let Ok(path) = syn::parse_str::<syn::Path>(&text.value()) {
                let path = path.segments.iter().map(|s| s.ident.to_string()).collect();
                self.module.mentions.push(Mention { path, line, modules: true });
            }
        }
    }
}

/// `#[cfg(test)]`, alone or in a condition.
pub fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let syn::Meta::List(list) = &attribute.meta else { return false };
        let words = list.tokens.to_string();
        list.path.is_ident("cfg") && words.split(|c: char| !c.is_alphanumeric()).any(|word| word == "test")
    })
}

/// Attributes of an item, and its name if it is one that paths lead to.
pub fn about(item: &syn::Item) -> (&[syn::Attribute], Option<&syn::Ident>) {
    match item {
        syn::Item::Const(item) => (&item.attrs, Some(&item.ident)),
        syn::Item::Enum(item) => (&item.attrs, Some(&item.ident)),
        syn::Item::Fn(item) => (&item.attrs, Some(&item.sig.ident)),
        syn::Item::Macro(item) => (&item.attrs, item.ident.as_ref()),
        syn::Item::Static(item) => (&item.attrs, Some(&item.ident)),
        syn::Item::Struct(item) => (&item.attrs, Some(&item.ident)),
        syn::Item::Trait(item) => (&item.attrs, Some(&item.ident)),
        syn::Item::Type(item) => (&item.attrs, Some(&item.ident)),
        syn::Item::Union(item) => (&item.attrs, Some(&item.ident)),
        syn::Item::Mod(item) => (&item.attrs, Some(&item.ident)),
        syn::Item::Impl(item) => (&item.attrs, None),
        syn::Item::Use(item) => (&item.attrs, None),
        _ => (&[], None),
    }
}

#[test]
fn a_use_leads_to_the_file_of_the_definition() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = [
        ("lib.rs", "mod a; mod b; mod c; mod d; pub use a::A; #[cfg(test)] mod tests;"),
        ("a/mod.rs", "mod inner; mod spare; pub use inner::A; pub use spare::spare;"),
        ("a/inner.rs", "pub struct A; pub mod deep { pub fn f() {} }"),
        ("a/spare.rs", "pub fn spare() {}"),
        // Through two re-exports; a module as a name; code for tests.
        ("b.rs", "use crate::A; fn b() {} #[cfg(test)] mod t { use crate::c::C; }"),
        // A string of an attribute, a macro call, a relative path.
        (
            "c.rs",
            "use super::a; #[serde(with = \"crate::d\")] pub struct C; fn c() { assert!(a::spare() == ()) }",
        ),
        ("d.rs", "use crate::a::*; fn d() { spare(); self::d() }"),
        ("tests.rs", "use crate::b::b;"),
    ];
    std::fs::create_dir(folder.path().join("a")).expect("a folder");
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    let found = graph(folder.path()).uses;
    let found: Vec<(&str, Vec<&str>)> =
        found.iter().map(|(from, to)| (from.as_str(), to.keys().map(String::as_str).collect())).collect();
    let expected = [
        ("a/inner.rs", vec![]),
        ("a/mod.rs", vec![]),
        ("a/spare.rs", vec![]),
        ("b.rs", vec!["a/inner.rs"]),
        ("c.rs", vec!["a/spare.rs", "d.rs"]),
        ("d.rs", vec!["a/mod.rs", "a/spare.rs"]),
        ("lib.rs", vec![]),
    ];
    assert_eq!(found, expected);
}
