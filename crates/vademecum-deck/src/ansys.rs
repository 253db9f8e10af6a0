//! Decks of Ansys (.cdb).

mod heat;

use std::collections::BTreeMap;
use std::path::Path;

use vademecum_build::fem::{Elasticity, Material, Stiffness};
use vademecum_build::mesh::ansys::{Command, commands, rotations};
use vademecum_build::mesh::nastran::number as fortran_real;
use vademecum_build::mesh::{MeshError, RawMesh, parse, repaired_deck};

use crate::deck::{Deck, Extent, Load, NodeNumber, Numbers, Step, StepKind, Support};
use crate::error::{CardFault, DeckError};
use crate::left_out::leave_out;

/// Commands without a meaning for linear answers, by their beginnings.
const SILENT: &[&str] = &[
    "ET", "KEYO", "R", "RL", "RMOR", "TYPE", "MAT", "REAL", "SECN", "SECT", "SECD", "NBLO", "EBLO", "CMBL",
    "N", "EXTO", "TREF", "BFUN", "ERES", "FINI", "NUMO", "MODO", "MODC", "QRDO", "DOF", "MPTE", "MPDA", "MP",
    "LSEL", "CSYS", "ESYS", "NSEL", "ESEL", "CMSE", "ALLS", "NROP", "NEQI", "AUTO", "DELT", "TIME", "KBC",
    "OUTR", "OUTP", "NSUB", "LUMP", "EQSL", "SOLV", "SAVE", "RESU", "CNVT", "NCNV", "LNSR", "PRED", "IRLF",
    "CGOM", "CGLO", "DCGO",
];

/// Consequence of tables that are not read.
const TABLES: &str = "it has no effect: rotation, damping and tables are not computed";

/// Labels of displacements and of forces, by component.
const DISPLACEMENTS: [&str; 6] = ["UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ"];
const FORCES: [&str; 6] = ["FX", "FY", "FZ", "MX", "MY", "MZ"];

/// State of the reading.
struct Reader<'a> {
    raw: &'a RawMesh,
    deck: Deck,
    numbers: Numbers,
    constants: BTreeMap<u64, Constants>,
    kind: StepKind,
    loads: Vec<Load>,
    heat: heat::Heat,
    /// Line of the first coordinate system of the deck's own.
    local: Option<usize>,
    /// Material whose anisotropic constants follow in `TBDATA`.
    anisotropic: Option<u64>,
}

/// Elastic constants and density as far as they were read.
#[derive(Clone, Copy, Debug, Default)]
struct Constants {
    /// Along x, y, z; zeros as along x.
    young: [f64; 3],
    /// Major ratios 12, 13, 23.
    poisson: [f64; 3],
    /// True if the deck has a ratio 12, in either form.
    has_poisson: bool,
    /// Minor ratios 12, 13, 23: contraction along the first axis under a pull along the second one.
    minor: [f64; 3],
    /// Shear moduli 12, 13, 23.
    shear: [f64; 3],
    density: f64,
    /// Upper triangle of an anisotropic stiffness, row by row, over xx, yy, zz, xy, yz, xz.
    triangle: Option<[f64; 21]>,
}

impl Constants {
    /// True if a constant belongs to one of several axes.
    fn is_orthotropic(&self) -> bool {
        if self.triangle.is_some() {
            return true;
        }
        // A shear modulus 12 alone stands beside isotropic constants, and agrees with them.
        self.young[1] != 0.0 || self.young[2] != 0.0 || self.shear[1..] != [0.0; 2]
    }

    /// `None` of no solid.
    fn elasticity(&self) -> Option<Elasticity> {
        if let Some(triangle) = &self.triangle {
            let stiffness = Stiffness::from_upper(triangle);
            return stiffness.is_definite().then_some(Elasticity::Anisotropic(stiffness));
        }
        let [ex, ey, ez] = self.young;
        let major = |k: usize, first: f64, second: f64| match self.minor[k] {
            0.0 => self.poisson[k],
            minor => minor * first / second,
        };
        if !self.is_orthotropic() {
            let poisson = if self.has_poisson { major(0, 1.0, 1.0) } else { DEFAULT_POISSON };
            let sound = ex > 0.0 && poisson > -1.0 && poisson < 0.5;
            return sound.then_some(Elasticity::Isotropic { young: ex, poisson });
        }
        let [ey, ez] = [ey, ez].map(|e| if e == 0.0 { ex } else { e });
        let poisson = [major(0, ex, ey), major(1, ex, ez), major(2, ey, ez)];
        let stiffness = Stiffness::orthotropic([ex, ey, ez], poisson, self.shear)?;
        stiffness.is_definite().then_some(Elasticity::Anisotropic(stiffness))
    }
}

/// Poisson's ratio of an isotropic material that has none in its deck, as Ansys takes it.
const DEFAULT_POISSON: f64 = 0.3;

/// Reads a deck.
pub(crate) fn read(file: &Path) -> Result<Deck, DeckError> {
    let raw = parse(file)?;
    let mesh = repaired_deck(&raw)?;
    let bytes = std::fs::read(file).map_err(|source| MeshError::Io { file: file.to_path_buf(), source })?;
    let all = raw.node_ids.iter().copied().zip(raw.nodes.iter().copied());
    let (numbers, points) = Numbers::new(&mesh, all);
    let mut deck = Deck::new(file, "Ansys", mesh, points);
    for (id, angles) in rotations(file, &bytes)? {
        if let (Some(node), true) = (numbers.get(id), angles != [0.0; 3]) {
            deck.axes.insert(node, turned(angles));
        }
    }
    let (constants, kind) = (BTreeMap::new(), StepKind::Static);
    let (loads, heat, local, anisotropic) = (vec![], heat::Heat::default(), None, None);
    let mut reader = Reader { raw: &raw, deck, numbers, constants, kind, loads, heat, local, anisotropic };
    for command in commands(file, &bytes)? {
        reader.take(&command)?;
    }
    reader.finish()
}

impl Reader<'_> {
    fn take(&mut self, command: &Command) -> Result<(), DeckError> {
        let name = command.name.to_ascii_uppercase();
        let short: String = name.chars().take(4).collect();
        match short.as_str() {
            "MP" => self.property(command, [0, 1, 2])?,
            // A table over temperatures goes on in further blocks.
            "MPDA" if number(command, 4).is_ok_and(|first| first > 1.0) => {
                self.leave(command, "temperature is not computed: the first value of the table is taken");
            }
            "MPDA" => self.property(command, [2, 3, 5])?,
            "LOCA" | "CS" | "CLOC" | "CSKP" | "CSWP" => self.local = self.local.or(Some(command.line)),
            "TREF" => {
                self.heat.reference = number(command, 0).map_err(|error| self.at(command, error))?;
            }
            // Programs write a name for a temperature that nobody gave.
            "BFUN" | "TUNI" => {
                let field = usize::from(short == "BFUN");
                let given = field == 0 || self::field(command, 0).eq_ignore_ascii_case("TEMP");
                self.heat.uniform = number(command, field).ok().filter(|_| given).or(self.heat.uniform);
            }
            "BF" if field(command, 1).eq_ignore_ascii_case("TEMP") => {
                let value = number(command, 2).map_err(|error| self.at(command, error))?;
                let nodes = self.nodes(command)?;
                self.heat.nodes.extend(nodes.into_iter().map(|node| (node, value)));
            }
            "D" => self.support(command)?,
            "F" => self.force(command)?,
            "ACEL" => {
                let a = [0, 1, 2].map(|k| number(command, k).map_err(|text| self.at(command, text)));
                let [x, y, z] = a;
                // The acceleration is that of the frame: bodies feel its opposite.
                let value = [-x?, -y?, -z?];
                if value != [0.0; 3] {
                    self.loads.push(Load::Acceleration { on: Extent::All, value });
                }
            }
            "ANTY" => {
                self.kind = match field(command, 0).to_ascii_uppercase().as_str() {
                    "" | "0" | "STATIC" => StepKind::Static,
                    "2" | "MODAL" => StepKind::Frequency(None),
                    other => StepKind::Other(format!("ANTYPE {other}")),
                };
            }
            "CE" | "CP" | "CERI" | "RBE3" | "CPIN" => {
                let expected = "a model without it: couplings of Ansys are not read yet";
                return Err(self.fault(command, &name, expected));
            }
            "SF" | "SFE" | "SFEB" | "BF" | "BFE" | "BFBL" | "SFBL" => {
                self.leave(command, "loads other than F and ACEL are not applied");
            }
            "TB" => {
                let anisotropic = field(command, 0).eq_ignore_ascii_case("ANEL");
                self.anisotropic = anisotropic.then(|| self.whole(command, 1)).transpose()?;
                match self.anisotropic {
                    Some(_) if number(command, 4) == Ok(1.0) => {
                        return Err(self.fault(command, "TBOPT 1", "a stiffness (TBOPT 0)"));
                    }
                    Some(material) => {
                        self.constants.entry(material).or_default().triangle = Some([0.0; 21]);
                    }
                    None => self.leave(command, TABLES),
                }
            }
            "TBDA" if self.anisotropic.is_some() => self.constants_of_table(command)?,
            "OMEG" | "DOME" | "CGLO" | "ALPH" | "BETA" | "DMPR" | "DMPS" | "TBDA" | "TBTE" => {
                let zero = (0..command.fields.len()).all(|k| number(command, k).unwrap_or(1.0) == 0.0);
                if !zero || name.starts_with("TB") {
                    self.leave(command, TABLES);
                }
            }
            // Comments, session commands, and assignments of the program's own language.
            short if SILENT.contains(&short) || short.starts_with(['/', '*', '_']) || name.contains('=') => {}
            _ => self.leave(command, "it is not known, and has no effect"),
        }
        Ok(())
    }

    /// Constants of an anisotropic stiffness, from the place in the first field on.
    fn constants_of_table(&mut self, command: &Command) -> Result<(), DeckError> {
        let first = number(command, 0).map_err(|error| self.at(command, error))?.max(1.0) as usize - 1;
        for index in 1..command.fields.len() {
            let value = number(command, index).map_err(|error| self.at(command, error))?;
            let material = self.anisotropic.and_then(|material| self.constants.get_mut(&material));
            let triangle = material.and_then(|constants| constants.triangle.as_mut());
            match triangle.and_then(|triangle| triangle.get_mut(first + index - 1)) {
                Some(slot) => *slot = value,
                None if field(command, index).is_empty() => {}
                None => return Err(self.fault(command, field(command, index), "at most 21 constants")),
            }
        }
        Ok(())
    }

    /// A constant of a material: fields of its name, number and value.
    fn property(&mut self, command: &Command, [name, material, value]: [usize; 3]) -> Result<(), DeckError> {
        let label = field(command, name).to_ascii_uppercase();
        let number_of = self.whole(command, material)?;
        let value = number(command, value).map_err(|error| self.at(command, error))?;
        let constants = self.constants.entry(number_of).or_default();
        constants.has_poisson |= matches!(&label[..], "PRXY" | "NUXY");
        match label.as_str() {
            "EX" => constants.young[0] = value,
            "EY" => constants.young[1] = value,
            "EZ" => constants.young[2] = value,
            "PRXY" => constants.poisson[0] = value,
            "PRXZ" => constants.poisson[1] = value,
            "PRYZ" => constants.poisson[2] = value,
            "NUXY" => constants.minor[0] = value,
            "NUXZ" => constants.minor[1] = value,
            "NUYZ" => constants.minor[2] = value,
            "GXY" => constants.shear[0] = value,
            "GXZ" => constants.shear[1] = value,
            "GYZ" => constants.shear[2] = value,
            "DENS" => constants.density = value,
            "ALPX" | "ALPY" | "ALPZ" => {
                let axis = usize::from(label.as_bytes()[3] - b'X');
                self.heat.expand(number_of, axis, value);
            }
            _ => self.leave(command, "elastic constants, ALPX, ALPY, ALPZ and the density act alone"),
        }
        Ok(())
    }

    fn support(&mut self, command: &Command) -> Result<(), DeckError> {
        let label = field(command, 1).to_ascii_uppercase();
        let value = number(command, 2).map_err(|error| self.at(command, error))?;
        let components: Vec<u8> = match label.as_str() {
            "ALL" => (0..6).collect(),
            _ => {
                DISPLACEMENTS.iter().position(|known| *known == label).map(|c| c as u8).into_iter().collect()
            }
        };
        if components.is_empty() {
            self.leave(command, "components other than displacements and rotations are not computed");
            return Ok(());
        }
        for node in self.nodes(command)? {
            self.deck.supports.extend(components.iter().map(|&component| Support { node, component, value }));
        }
        Ok(())
    }

    fn force(&mut self, command: &Command) -> Result<(), DeckError> {
        let label = field(command, 1).to_ascii_uppercase();
        let value = number(command, 2).map_err(|error| self.at(command, error))?;
        let Some(component) = FORCES.iter().position(|known| *known == label) else {
            self.leave(command, "loads other than forces and moments are not applied");
            return Ok(());
        };
        let component = component as u8;
        let nodes = self.nodes(command)?;
        self.loads.extend(nodes.into_iter().map(|node| Load::Force { node, component, value }));
        Ok(())
    }

    /// Nodes of the first field: a number, `ALL`, or a component.
    fn nodes(&self, command: &Command) -> Result<Vec<NodeNumber>, DeckError> {
        let name = field(command, 0);
        if name.eq_ignore_ascii_case("ALL") {
            return Ok((0..self.deck.mesh.nodes.len() as NodeNumber).collect());
        }
        if let Some(node) = name.parse().ok().and_then(|id| self.numbers.get(id)) {
            return Ok(vec![node]);
        }
        let group = self.raw.node_groups.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        let ids = group.map(|(_, nodes)| nodes.iter().filter_map(|&n| self.raw.node_ids.get(n as usize)));
        match ids {
            Some(ids) => Ok(ids.filter_map(|&id| self.numbers.get(id)).collect()),
            None => Err(self.fault(command, name, "a node of the deck, or a component of nodes")),
        }
    }

    fn whole(&self, command: &Command, index: usize) -> Result<u64, DeckError> {
        let text = field(command, index);
        text.parse().map_err(|_| self.fault(command, text, "a whole number"))
    }

    fn fault(&self, command: &Command, found: &str, expected: &str) -> DeckError {
        DeckError::Card(Box::new(CardFault {
            file: self.deck.file.clone(),
            line: command.line,
            card: command.name.clone(),
            found: format!("`{}`", found.chars().take(60).collect::<String>().escape_debug()),
            expected: expected.into(),
            remedy: "correct the deck, or take the command out of it".into(),
        }))
    }

    fn at(&self, command: &Command, text: String) -> DeckError {
        self.fault(command, &text, "a number")
    }

    fn leave(&mut self, command: &Command, meaning: &str) {
        let place = (self.deck.file.clone(), command.line);
        leave_out(&mut self.deck.left_out, place, &command.name, meaning);
    }

    fn finish(mut self) -> Result<Deck, DeckError> {
        for region in &self.deck.mesh.regions {
            let found = self.constants.get(&(region.tag as u64));
            let found = found.filter(|found| found.young[0] > 0.0 || found.triangle.is_some());
            let found = found.ok_or_else(|| DeckError::NoMaterial { region: region.name.clone() })?;
            let missing =
                |quantity, card| DeckError::Incomplete { material: region.name.clone(), quantity, card };
            if found.triangle.is_none() && found.is_orthotropic() && found.shear.contains(&0.0) {
                return Err(missing("shear modulus in each plane", "GXY, GXZ and GYZ beside EY and EZ"));
            }
            // Their axes are those of the elements, whose systems are not read.
            if (found.is_orthotropic() || self.heat.has_axes()) && self.local.is_some() {
                return Err(missing("axes that are known", "elements in system 0, without LOCAL,"));
            }
            let elasticity = found.elasticity().ok_or_else(|| {
                let card = "EX, EY, EZ, PRXY, PRXZ, PRYZ, GXY, GXZ and GYZ";
                missing("positive definite stiffness", card)
            })?;
            self.deck.materials.push(Material { elasticity, density: found.density });
        }
        self.deck.lumped = vec![false; self.deck.materials.len()];
        let (name, supports) = ("1".to_string(), vec![]);
        let temperatures = self.heat.finish(&mut self.deck);
        self.deck.steps.push(Step {
            name,
            kind: self.kind,
            loads: self.loads,
            supports,
            temperatures,
            about: None,
            line: 1,
        });
        Ok(self.deck)
    }
}

/// Unit vectors of axes that are turned by angles about z, then x, then y, in degrees.
fn turned(angles: [f64; 3]) -> [[f64; 3]; 3] {
    let [(sz, cz), (sx, cx), (sy, cy)] = angles.map(|angle| angle.to_radians().sin_cos());
    [
        [cz * cy - sz * sx * sy, sz * cy + cz * sx * sy, -cx * sy],
        [-sz * cx, cz * cx, sx],
        [cz * sy + sz * sx * cy, sz * sy - cz * sx * cy, cx * cy],
    ]
}

fn field(command: &Command, index: usize) -> &str {
    command.fields.get(index).map_or("", |field| field.trim())
}

/// The number in a field, 0 if it is blank; the text if it is none.
fn number(command: &Command, index: usize) -> Result<f64, String> {
    let text = field(command, index);
    if text.is_empty() {
        return Ok(0.0);
    }
    fortran_real(text).ok_or_else(|| text.to_string())
}
