//! The checks a problem file passes before anything is read: the numbered refusals of `formats/problem-1.md`.

use super::{
    BasisKind, Fields, MaterialEntry, OrthotropicEntry, ParameterEntry, ParameterKind, ParameterScale,
    Problem, ProblemError, Representation,
};
use crate::dynamics::SchemeKind;
use crate::fem::Stiffness;
use crate::input::toml_file::TomlError;
use crate::limits::MAGNITUDE;

/// True of two directions at a right angle.
pub(crate) fn perpendicular([first, second]: [[f64; 3]; 2]) -> bool {
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (one, two) = (dot(first, first), dot(second, second));
    // Squares of lengths between the magnitudes that a problem may have.
    let length = |square: f64| (MAGNITUDE.0.powi(2)..=MAGNITUDE.1.powi(2)).contains(&square);
    let some = length(one) && length(two);
    some && dot(first, second).abs() <= 1e-6 * (one * two).sqrt()
}

/// Damping ratios of modes.
const MAX_RATIOS: usize = 100_000;

/// First columns of the table of probes, which no probe may have the name of.
pub const OWN_COLUMNS: [&str; 2] = ["time_s", "energy_J"];

/// Names of the load patterns that a body without supports gets: the centrifugal forces of one rad²/s² of
/// each product of components of its angular velocity.
pub(crate) const CENTRIFUGAL: [&str; 6] = [
    "centrifugal xx",
    "centrifugal yy",
    "centrifugal zz",
    "centrifugal xy",
    "centrifugal yz",
    "centrifugal zx",
];

impl Problem {
    pub(super) fn check(&self) -> Result<(), ProblemError> {
        self.check_texts()?;
        self.check_mesh()?;
        if self.mesh.matrices.is_some() {
            self.check_matrices()?;
        } else {
            self.check_materials()?;
        }
        self.check_ranges()?;
        for (i, support) in self.supports.iter().enumerate() {
            let held = !support.components.is_empty();
            self.require(
                held,
                &format!("support[{i}].components"),
                Words("empty"),
                "at least one of \"x\", \"y\", \"z\"",
            )?;
            let name = support.name(i);
            let twice = self.supports[..i].iter().enumerate().any(|(j, other)| other.name(j) == name);
            self.require(
                !name.is_empty() && !name.contains(['\n', ',', '"']) && !twice,
                &format!("support[{i}].name"),
                format_args!("{name:?}"),
                "a name of one line without comma and quotation mark that no other support has",
            )?;
        }
        self.check_attachments()?;
        self.check_ports()?;
        self.check_patch()?;
        self.check_reactions()?;
        self.check_base()?;
        self.check_damping()?;
        self.check_loads()?;
        self.check_temperatures()?;
        self.check_time_and_basis()?;
        self.check_parameters()?;
        self.check_chapter()?;
        self.check_large()?;
        self.check_prestress()?;
        self.check_sizes()?;
        self.check_scales()
    }

    fn check_mesh(&self) -> Result<(), ProblemError> {
        let mesh = &self.mesh;
        let sources = [
            ("file", mesh.file.is_some()),
            ("tables", mesh.tables.is_some()),
            ("block", mesh.block.is_some()),
            ("matrices", mesh.matrices.is_some()),
        ];
        self.require_one("mesh", &sources, "exactly one of `file`, `tables`, `block` and `matrices`")
    }

    /// Matrices have no elements: keys that need them are refused.
    fn check_matrices(&self) -> Result<(), ProblemError> {
        const BESIDE: Words = Words("present beside `mesh.matrices`");
        let regions = self.mesh.regions.is_empty();
        self.require(regions, "mesh.region", BESIDE, "none: matrices have one region, `body`")?;
        let order = self.mesh.order.is_none();
        self.require(order, "mesh.order", BESIDE, "none: matrices have no elements to raise")?;
        let cells = self.mesh.cells.is_none();
        self.require(cells, "mesh.cells", BESIDE, "none: matrices have no surface to fill")?;
        let whole = self.mesh.smallest_part == 0.0;
        self.require(whole, "mesh.smallest_part", BESIDE, "none: matrices have no elements to leave out")?;
        let embedded = self.output.embedded.is_none();
        self.require(embedded, "output.embedded", BESIDE, "none: matrices have no tetrahedra")?;
        let materials = self.materials.is_empty();
        self.require(materials, "material", BESIDE, "none: the matrices have the materials in them")?;
        let supports = self.supports.is_empty();
        self.require(
            supports,
            "support",
            BESIDE,
            "none: a dof without a row in `mesh.matrices.dofs` is held",
        )?;
        for (i, pattern) in self.load.patterns.iter().enumerate() {
            let body_force = pattern.acceleration.is_some();
            let expected = "`acceleration`: other loads need the nodes and facets of elements";
            self.require(body_force, &format!("load.pattern[{i}]"), BESIDE, expected)?;
        }
        let stress = self.output.stress.is_none();
        self.require(stress, "output.stress", BESIDE, "none: stress needs elements and materials")?;
        Ok(())
    }

    fn check_materials(&self) -> Result<(), ProblemError> {
        self.require(!self.materials.is_empty(), "material", Words("absent"), "at least one `[[material]]`")?;
        for (i, m) in self.materials.iter().enumerate() {
            let twice = self.materials[..i].iter().any(|other| other.region == m.region);
            let key = format!("material[{i}].region");
            self.require(!twice, &key, &m.region, "a region no other material names")?;
            self.check_elasticity(i, m)?;
        }
        Ok(())
    }

    fn check_elasticity(&self, index: usize, m: &MaterialEntry) -> Result<(), ProblemError> {
        let key = |name: &str| format!("material[{index}]{name}");
        let isotropic = [m.young, m.poisson].iter().flatten().count();
        let others = usize::from(m.orthotropic.is_some()) + usize::from(m.stiffness.is_some());
        let found = match (isotropic, others) {
            (2, 0) | (0, 1) => "",
            (0, 0) => "without constants of elasticity",
            (1, 0) => "with one of `young` and `poisson`",
            _ => "with constants of several laws",
        };
        let expected = "`young` and `poisson`, or `orthotropic`, or `stiffness`";
        self.require(found.is_empty(), &key(""), Words(found), expected)?;
        if let Some(axes) = m.axes {
            self.require(others == 1, &key(".axes"), axes, "none beside `young` and `poisson`")?;
            self.require(perpendicular(axes), &key(".axes"), axes, "two perpendicular directions")?;
        }
        let size = |x: &f64| (MAGNITUDE.0..=MAGNITUDE.1).contains(x);
        if let Some(OrthotropicEntry { young, shear, .. }) = &m.orthotropic {
            let expected = "moduli from 1e-30 to 1e30";
            self.require(young.iter().all(size), &key(".orthotropic.young"), *young, expected)?;
            self.require(shear.iter().all(size), &key(".orthotropic.shear"), *shear, expected)?;
        }
        if let Some(stiffness) = &m.stiffness {
            let whole = Stiffness::from_upper(stiffness).0;
            let sound =
                (0..6).all(|i| size(&whole[i][i])) && stiffness.iter().all(|c| c.abs() <= MAGNITUDE.1);
            let expected = "finite constants, those on the diagonal from 1e-30 to 1e30";
            self.require(sound, &key(".stiffness"), Words("constants beyond that"), expected)?;
        }
        let expected = "the constants of a solid: every strain has a positive energy";
        let sound = m.elasticity().is_some();
        let name = if m.stiffness.is_some() { ".stiffness" } else { ".orthotropic" };
        self.require(sound, &key(name), Words("not positive definite"), expected)
    }

    fn check_damping(&self) -> Result<(), ProblemError> {
        let d = &self.damping;
        let both = d.ratios.is_some() && (d.alpha.is_some() || d.beta.is_some());
        self.require(!both, "damping", Words("`ratios` beside `alpha` or `beta`"), "one or the other")?;
        if let Some(pairs) = d.ratios {
            let usable = pairs.iter().all(|p| p[0] >= 0.0 && positive(p[1])) && pairs[0][1] != pairs[1][1];
            self.require(
                usable,
                "damping.ratios",
                pairs,
                "two pairs [ratio ≥ 0, frequency > 0] at two frequencies",
            )?;
        }
        self.check_modal_damping()?;
        self.check_loss()?;
        self.check_static_fields()?;
        let found = d.damping().rayleigh();
        found.map(|_| ()).map_err(|source| ProblemError::Damping { path: self.place("damping"), source })
    }

    /// Ratios of modes belong to modes that are moved one by one.
    fn check_modal_damping(&self) -> Result<(), ProblemError> {
        let d = &self.damping;
        let both = d.modal.is_some() && d.ratio.is_some();
        self.require(!both, "damping", Words("`modal` beside `ratio`"), "one of them")?;
        let Some(key) = d.modal.as_ref().map(|_| "damping.modal").or(d.ratio.map(|_| "damping.ratio")) else {
            return Ok(());
        };
        let ratios = d.modal_ratios().0;
        self.require(
            !ratios.is_empty() && ratios.len() <= MAX_RATIOS,
            key,
            format_args!("a list of {}", ratios.len()),
            "1 to 100 000 ratios",
        )?;
        let exact = self.scheme() == (SchemeKind::Exact {});
        let turned = self.is_parametric() && d.modal.is_some();
        let found = if self.basis.kind == Some(BasisKind::Pod) {
            "given beside `basis.kind = \"pod\"`".to_string()
        } else if turned {
            "given beside live regions, over which modes change places".to_string()
        } else if exact {
            format!("given beside a basis of {}", self.basis_kind().words())
        } else {
            format!("given beside the time scheme {}", self.scheme())
        };
        self.require_with(
            exact && self.basis_kind() == BasisKind::Modes && !turned,
            key,
            || found,
            "`time.scheme = { name = \"exact\" }` and `basis.kind = \"modes\"`: only natural modes that are moved \
             exactly have a damping ratio of their own, and a march at full order has none",
        )
    }

    /// Loss factors damp natural modes that are moved exactly: they are no matrix of a march.
    fn check_loss(&self) -> Result<(), ProblemError> {
        let given = |entry: &MaterialEntry| entry.loss_factor.is_some();
        let place = self.materials.iter().position(given).map(|i| format!("material[{i}].loss_factor"));
        let Some(key) = place.or(self.has_loss().then(|| "parameter".into())) else { return Ok(()) };
        let found = if self.is_large() {
            "beside `model = \"large-displacement\"`"
        } else if self.prestress.is_some() {
            "beside `[prestress]`"
        } else if self.scheme() != (SchemeKind::Exact {}) {
            "beside a `time.scheme` that is not exact"
        } else if self.basis_kind() != BasisKind::Modes {
            "beside a basis that is not of natural modes"
        } else {
            return Ok(());
        };
        self.require(false, &key, Words(found), "natural modes of linear motion that are moved exactly")
    }

    fn check_loads(&self) -> Result<(), ProblemError> {
        for (i, p) in self.load.patterns.iter().enumerate() {
            let key = format!("load.pattern[{i}]");
            let kinds = [
                ("acceleration", p.acceleration.is_some()),
                ("traction", p.traction.is_some()),
                ("pressure", p.pressure.is_some()),
                ("temperature", p.temperature.is_some()),
                ("forces", p.forces.is_some()),
                ("reference", p.reference.is_some()),
            ];
            let expected = "exactly one of `acceleration`, `traction`, `pressure`, `temperature`, `forces` and `reference`";
            self.require_one(&key, &kinds, expected)?;
            let of_facets = p.traction.is_some() || p.pressure.is_some();
            let found = match p.on.is_some() {
                true if p.acceleration.is_some() => "an acceleration with `on`",
                true => "forces at nodes or at a reference point with `on`",
                false => "a load of facets without `on`",
            };
            let expected = "`on` for traction and pressure, and else for a temperature alone";
            let placed = of_facets == p.on.is_some() || p.temperature.is_some();
            self.require(placed, &key, Words(found), expected)?;
            let forces = p.force.is_some() || p.moment.is_some();
            let found = if forces { "`force` or `moment` without `reference`" } else { "`reference` alone" };
            let expected = "`force`, `moment` or both beside `reference`, and nowhere else";
            self.require(forces == p.reference.is_some(), &key, Words(found), expected)?;
            if let Some(name) = &p.reference {
                self.named_point(&format!("{key}.reference"), name)?;
            }
            let twice = self.load.patterns[..i].iter().any(|other| other.name == p.name);
            let name = !p.name.is_empty() && !p.name.contains('\n') && !twice;
            self.require(
                name,
                &format!("{key}.name"),
                &p.name,
                "a name of one line that no other pattern has",
            )?;
            let vectors = [&p.acceleration, &p.traction, &p.force, &p.moment].into_iter().flatten().flatten();
            let nodal = p.forces.iter().flatten().flat_map(|force| force.force());
            let finite =
                vectors.chain(&p.pressure).chain(&p.temperature).copied().chain(nodal).all(f64::is_finite);
            self.require(finite, &key, Words("not a number or infinite"), "finite numbers")?;
        }
        self.check_probes()
    }

    fn check_probes(&self) -> Result<(), ProblemError> {
        let output = &self.output;
        let probes = output.probes.iter().map(|p| (&p.name, p.point, p.direction));
        let gauges = output.gauges.iter().map(|g| (&g.name, g.point, g.direction));
        let keys = (0..output.probes.len()).map(|i| format!("output.probe[{i}]"));
        let keys = keys.chain((0..output.gauges.len()).map(|i| format!("output.gauge[{i}]")));
        let mut known: Vec<&String> = vec![];
        for (key, (name, point, direction)) in keys.zip(probes.chain(gauges)) {
            let one_line = !name.is_empty() && !name.contains(['\n', ',', '"']);
            let usable = one_line && !known.contains(&name) && !OWN_COLUMNS.contains(&name.as_str());
            let expected = "a name of one line that no other probe or gauge has, nor `time_s` or `energy_J`";
            self.require(usable, &format!("{key}.name"), name, expected)?;
            known.push(name);
            let finite = point.iter().all(|value| value.is_finite());
            self.require(finite, &format!("{key}.point"), point, "finite numbers")?;
            let length: f64 = direction.iter().map(|c| c * c).sum();
            let key = format!("{key}.direction");
            self.require(positive(length), &key, direction, "a vector of some length")?;
        }
        let wanted = output.stress_residual == Some(true);
        let found = Words("true without `output.stress`, or beside `output.residual = false`");
        let there = output.stress.is_some() && output.residual != Some(false);
        self.require(!wanted || there, "output.stress_residual", found, "`output.stress` and the residual")
    }

    /// A base that moves needs elements and supports, patterns, and the mass as built.
    fn check_base(&self) -> Result<(), ProblemError> {
        let base = &self.base;
        let finite = base.point.iter().all(|x| x.is_finite());
        self.require(finite, "base.point", base.point, "finite numbers")?;
        if !base.moves {
            return Ok(());
        }
        let found = if self.mesh.matrices.is_some() {
            "true beside `mesh.matrices`, which do not know the mass of held displacements"
        } else if self.representation == Some(Representation::Canonical) {
            "true beside `representation = \"chapter\"`, which takes no load patterns"
        } else if self.parameters.iter().any(|p| p.kind.is_mass()) {
            "true beside a live density, which the inertia of a moving body follows and a load pattern does not"
        } else if self.supports.is_empty() {
            "true without any `[[support]]`"
        } else {
            ""
        };
        let expected = "false, or a body of elements on supports whose density is fixed";
        self.require(found.is_empty(), "base.moves", Words(found), expected)?;
        for (i, pattern) in self.load.patterns.iter().enumerate() {
            self.require(
                !pattern.name.starts_with("base."),
                &format!("load.pattern[{i}].name"),
                &pattern.name,
                "a name that does not begin with `base.`: those are the motions of the base",
            )?;
        }
        Ok(())
    }

    /// Reactions need elements, and modes that move apart.
    fn check_reactions(&self) -> Result<(), ProblemError> {
        let found = if self.mesh.matrices.is_some() {
            "true beside `mesh.matrices`, whose rows are the free dofs alone"
        } else if self.representation == Some(Representation::Canonical) {
            "true beside `representation = \"chapter\"`"
        } else if self.basis.kind == Some(BasisKind::Pod) {
            "true beside `basis.kind = \"pod\"`, whose vectors do not move apart"
        } else if !self.is_parametric() && self.has_local_parameters() {
            "true beside a step that is separated over live regions, which change how supports share a load"
        } else if self.supports.is_empty() {
            "true without any `[[support]]`"
        } else {
            return Ok(());
        };
        let expected = "false, or a body of elements on supports, with the basis \"modes\" or \"ritz\" and no \
                        separated step";
        self.require(!self.output.reactions, "output.reactions", Words(found), expected)
    }

    /// The factor of the stiffness goes with the residual flexibility and with fields of the whole body.
    fn check_static_fields(&self) -> Result<(), ProblemError> {
        let exact = self.scheme() == (SchemeKind::Exact {});
        let found = if !exact {
            format!("given beside the time scheme {}", self.scheme())
        } else if self.output.residual == Some(false) {
            "given beside `output.residual = false`".to_string()
        } else {
            "given beside `output.fields = \"surface\"`".to_string()
        };
        let whole = self.output.residual != Some(false) && self.output.fields == Fields::Body;
        self.require_with(
            self.output.static_fields != Some(true) || (exact && whole),
            "output.static_fields",
            || found,
            "`time.scheme = { name = \"exact\" }`, `output.residual` and `output.fields = \"body\"`",
        )
    }

    fn check_time_and_basis(&self) -> Result<(), ProblemError> {
        let scheme = self.scheme().table();
        scheme.map_err(|source| ProblemError::Scheme { path: self.place("time.scheme"), source })?;
        if self.scheme() == (SchemeKind::Exact {}) {
            self.check_exact()?;
        }
        let plan = &self.snapshots;
        let directions = &plan.directions;
        let usable =
            !directions.is_empty() && directions.iter().all(|d| positive(d.iter().map(|c| c * c).sum()));
        self.require(usable, "snapshots.directions", directions, "vectors of some length")?;
        self.require(
            !(plan.npy.is_some() && plan.vtu.is_some()),
            "snapshots",
            Words("`npy` beside `vtu`"),
            "one of them",
        )?;
        let basis = &self.basis;
        self.require(
            basis.modes.is_none() || basis.energy.is_none(),
            "basis",
            Words("`modes` beside `energy`"),
            "one of them",
        )?;
        self.require(
            basis.error.is_none() || (self.basis_kind() == BasisKind::Modes && !self.is_parametric()),
            "basis.error",
            basis.error.unwrap_or(0.0),
            "`kind = \"modes\"` beside it, and no live regions",
        )?;
        self.require(
            basis.error.is_none() || (basis.modes.is_none() && basis.energy.is_none()),
            "basis",
            Words("`error` beside `modes` or `energy`"),
            "one of them",
        )
    }

    /// Exact integration needs uncoupled modes.
    fn check_exact(&self) -> Result<(), ProblemError> {
        let key = "time.scheme";
        self.require(
            self.basis.kind != Some(BasisKind::Pod),
            key,
            Words("exact, beside `basis.kind = \"pod\"`"),
            "a scheme such as `{ name = \"bathe\" }`, or the basis \"ritz\" or \"modes\", whose vectors move apart",
        )?;
        self.require(
            self.representation != Some(Representation::Canonical),
            key,
            Words("exact, beside `representation = \"chapter\"`"),
            "a scheme such as `{ name = \"bathe\" }`: stage maps need stages",
        )?;
        let by = self.separated_by().filter(|_| self.has_local_parameters());
        self.require_with(
            by.is_none(),
            key,
            || format!("exact, beside a live parameter of a region and {}", by.unwrap_or_default()),
            "no such key, for a parametric reduced-order model, or a scheme such as `{ name = \"bathe\" }`: \
             stages are what is separated over a region's stiffness or density",
        )
    }

    /// Checks of a problem without supports, before it is computed: the body then moves at its own
    /// modes, beside a rigid motion that is not stepped by stages.
    pub(crate) fn check_free(&self) -> Result<(), ProblemError> {
        if !self.is_free() {
            return Ok(());
        }
        let exact = self.scheme() == (SchemeKind::Exact {});
        let found = || match self.has_local_parameters() {
            true => "none beside a live parameter of a region".into(),
            false => format!("none beside the time scheme {}", self.scheme()),
        };
        let expected = "`[[support]]`, or for a body that flies freely `time.scheme = { name = \"exact\" }`";
        self.require_with(exact, "support", found, expected)?;
        self.require_with(
            self.basis_kind() == BasisKind::Modes,
            "support",
            || format!("none beside a basis of {}", self.basis_kind().words()),
            "`[[support]]`, or for a body that flies freely `basis.kind = \"modes\"` and no key of snapshots",
        )?;
        let density = self.parameters.iter().any(|p| p.kind.is_mass());
        self.require(
            !(self.is_parametric() && density),
            "support",
            Words("none beside live regions and a live density"),
            "`[[support]]`, or no live density: the mass of a body that flies freely is that as built",
        )?;
        self.require(
            self.output.static_fields != Some(true),
            "output.static_fields",
            Words("true beside no `[[support]]`"),
            "a body that is held: a free one has no factor that a file could keep",
        )?;
        for (i, pattern) in self.load.patterns.iter().enumerate() {
            self.require(
                !CENTRIFUGAL.contains(&pattern.name.as_str()),
                &format!("load.pattern[{i}].name"),
                &pattern.name,
                "another name: a body without `[[support]]` has this pattern already",
            )?;
        }
        Ok(())
    }

    fn check_parameters(&self) -> Result<(), ProblemError> {
        for (i, p) in self.parameters.iter().enumerate() {
            let key = |name: &str| format!("parameter[{i}].{name}");
            let earlier = &self.parameters[..i];
            let name =
                !p.name.is_empty() && !p.name.contains('\n') && !earlier.iter().any(|o| o.name == p.name);
            self.require(name, &key("name"), &p.name, "a name of one line that no other parameter has")?;
            let same =
                |o: &ParameterEntry| o.kind == p.kind && o.region == p.region && o.attachment == p.attachment;
            let twice = earlier.iter().any(same);
            self.require(
                !twice,
                &key("kind"),
                Words(p.kind.name()),
                "a quantity no other parameter changes",
            )?;
            self.check_live_attachment(i, p)?;
            use ParameterKind as K;
            let of_region = matches!(p.kind, K::Stiffness | K::Density | K::LossFactor);
            let named = p.kind != K::LossFactor || p.region != "*";
            self.require(named, &key("region"), &p.region, "the region whose loss factor it is")?;
            self.require(of_region || p.region == "*", &key("region"), &p.region, "no region for this kind")?;
            let [lower, upper] = p.range;
            let ordered = lower < upper && upper.is_finite();
            self.require(ordered, &key("range"), p.range, "two finite numbers, the smaller first")?;
            let may_vanish = p.kind.may_vanish();
            let above_zero = lower > 0.0 || (lower == 0.0 && may_vanish && p.scale == ParameterScale::Linear);
            self.require(
                above_zero,
                &key("range"),
                p.range,
                "a range above zero (on a linear scale alpha, beta, damping and loss-factor may start at 0)",
            )?;
        }
        Ok(())
    }

    pub(super) fn require(
        &self,
        holds: bool,
        key: &str,
        found: impl std::fmt::Debug,
        expected: impl Into<String>,
    ) -> Result<(), ProblemError> {
        self.require_with(holds, key, || format!("{found:?}"), expected)
    }

    /// The same for what is found in words.
    pub(super) fn require_with(
        &self,
        holds: bool,
        key: &str,
        found: impl FnOnce() -> String,
        expected: impl Into<String>,
    ) -> Result<(), ProblemError> {
        if holds {
            return Ok(());
        }
        let (path, found, expected) = (self.place(key), found(), expected.into());
        Err(TomlError::Impossible { path, key: key.into(), found, expected }.into())
    }

    /// A table with exactly one of several keys.
    fn require_one(
        &self,
        key: &str,
        given: &[(&str, bool)],
        expected: &'static str,
    ) -> Result<(), ProblemError> {
        let named: Vec<String> = given.iter().filter(|g| g.1).map(|g| format!("`{}`", g.0)).collect();
        let found = || match named.is_empty() {
            true => "a table with none of its main keys".into(),
            false => format!("a table with {}", named.join(" and ")),
        };
        self.require_with(named.len() == 1, key, found, expected)
    }
}

/// The found value in words: a text that a file holds is shown in quotes, these are not.
#[derive(Clone, Copy)]
pub(super) struct Words(pub &'static str);

impl std::fmt::Debug for Words {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0)
    }
}

pub(super) fn positive(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

impl Problem {
    pub(super) fn check_chapter(&self) -> Result<(), ProblemError> {
        let asked = self.representation == Some(Representation::Canonical);
        self.require(
            !asked || self.parameters.is_empty(),
            "representation",
            Words("chapter beside `[[parameter]]`"),
            "\"parametric\" or \"separated\", where parameters are live",
        )?;
        let beside = match self.representation {
            Some(Representation::Parametric) => self.beside_parametric(),
            _ => None,
        };
        self.require_with(
            beside.is_none(),
            "representation",
            || format!("parametric beside {}", beside.unwrap_or_default()),
            "exact steps and a basis of natural modes, without that key; or \"separated\"",
        )?;
        let Some(c) = &self.canonical else { return Ok(()) };
        self.require(asked, "canonical", Words("a table"), "`representation = \"chapter\"` beside it")?;
        let [lower, upper] = c.load;
        let load = lower <= 0.0 && upper >= 0.0 && lower < upper && (upper - lower).is_finite();
        self.require(load, "canonical.load", c.load, "two finite numbers around zero, the smaller first")?;
        let length = c.direction.is_none_or(|d| positive(d.iter().map(|x| x * x).sum()));
        let found = c.direction.unwrap_or_default();
        self.require(length, "canonical.direction", found, "a vector of some length")?;
        let one = !(c.components && c.direction.is_some());
        self.require(one, "canonical.components", Words("true beside `direction`"), "one of them")
    }
}
