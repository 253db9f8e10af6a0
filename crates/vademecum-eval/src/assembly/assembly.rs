//! An assembly: bodies joined at bind to the bytes of one ordinary file, in lent memory.

use crate::assembly::carry::{self, JointEnergy, JointForce, carry_work};
use crate::assembly::counts::Counts;
use crate::assembly::damping::Damping;
use crate::assembly::error::{AssemblyError, JointFault};
use crate::assembly::inputs::Inputs;
use crate::assembly::joint::Joint;
use crate::assembly::part::Part;
use crate::assembly::residual::Residual;
use crate::assembly::states::PartState;
use crate::assembly::synthesis::{Synthesis, short};
use crate::assembly::write::{Joined, Sections};
use crate::base::lend::Lender;
use vademecum_format::scheme::SchemeTable;
use vademecum_format::{
    Axis, Certificate, File, FormatError, MAX_AXES, MAX_PARAMETERS, Metadata, Parameter, SectionKind,
    checksum, encode_filled, filled_len,
};

/// Steps of the first period that a proposed step takes at least.
const STEPS_PER_PERIOD: f64 = 40.0;

/// Largest power of ten that binary64 holds exactly.
const EXACT_POWER: i32 = 22;

/// Options of an assembly.
#[derive(Clone, Copy, Debug)]
pub struct AssemblyOptions<'a> {
    /// Step of the joined body \[s\]; `None`: 1, 2 or 5 times a power of ten, with at least 40 steps in its
    /// first period.
    pub time_step: Option<f64>,
    /// With the inertia of what the modes of the parts leave out, where all of them have it: Rubin's
    /// synthesis. Without it MacNeal's.
    pub inertia: bool,
    /// States of the parts at the instant of joining, for joints that are made as they stand.
    pub states: &'a [PartState<'a>],
    /// Name and version of the program in the file.
    pub program: &'a str,
    /// Text that the file keeps in place of that of a problem.
    pub problem: &'a str,
    /// Hash of the mesh in the file; `None`: one of the hashes and places of the parts.
    pub mesh_hash: Option<[u8; 16]>,
}

impl Default for AssemblyOptions<'_> {
    fn default() -> Self {
        Self {
            time_step: None,
            inertia: true,
            states: &[],
            program: concat!("vademecum-eval ", env!("CARGO_PKG_VERSION")),
            problem: "",
            mesh_hash: None,
        }
    }
}

impl<'a> AssemblyOptions<'a> {
    /// The same with the states that the parts have, for [`Joint::as_it_stands`].
    #[must_use]
    pub const fn as_it_stands(self, states: &'a [PartState<'a>]) -> Self {
        Self { states, ..self }
    }
}

/// Memory to lend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AssemblySizes {
    /// Bytes of the joined file; where modes are coupled by damping, their largest number.
    pub bytes: usize,
    /// Numbers that the assembly keeps.
    pub memory: usize,
    /// Numbers of work, while it is bound or a state is carried.
    pub work: usize,
    /// Coordinates of all parts, as many as the joined body has.
    pub coordinates: usize,
    /// Rows of all joints.
    pub rows: usize,
}

/// Report of an assembly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AssemblyNumbers<'a> {
    /// Squares of the angular frequencies of its modes \[rad²/s²\], ascending.
    pub eigenvalues: &'a [f64],
    /// True of Rubin's synthesis; false of MacNeal's.
    pub rubin: bool,
    /// Rows of all joints.
    pub rows: usize,
    /// Largest distance between the ports of each joint \[m\].
    pub distances: &'a [f64],
    /// Largest change of an answer at a natural frequency by damping that couples modes; 0 where none does.
    pub damping_coupling: f64,
    /// True if the file holds the damping that couples modes; else its size is `damping_coupling`.
    pub damping_coupled: bool,
    /// True if the body answers contacts with residual flexibility.
    pub residual: bool,
    /// Step \[s\].
    pub time_step: f64,
}

/// Bodies joined at bind.
///
/// The joined body is an ordinary file, [`Assembly::file`]: whatever takes a body takes it. The assembly
/// itself carries states to and from the parts and gives the forces of the joints.
///
/// Two masses of 1 kg, by hand: on springs of 1 and 3 N/m to the ground, with 2 N/m between them. Their
/// stiffness is `[[3, −2], [−2, 5]]`, and its eigenvalues are `4 ∓ √5`.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/masses.rs"));
/// use vademecum_eval::format::File;
/// use vademecum_eval::{Assembly, AssemblyOptions, Body, BodyOptions, End, Joint, Part, Pose};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let (first, second) = (mass_on_spring(1.0), mass_on_spring(3.0));
/// let parts = [
///     Part::new("a", File::parse(&first)?, Pose::IDENTITY)?,
///     Part::new("b", File::parse(&second)?, Pose::IDENTITY)?,
/// ];
/// let [a, b] = ["a.end", "b.end"].map(|name| End::find(&parts, name));
/// let stiffness = [2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
/// let joints = [Joint::bushing(a.ok_or("a port")?, b, &stiffness)];
///
/// // Lend. Nothing is allocated from here on.
/// let options = AssemblyOptions::default();
/// let sizes = Assembly::sizes(&parts, &joints, &options)?;
/// let mut bytes = vec![0; sizes.bytes];
/// let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
/// let assembly = Assembly::bind(&parts, &joints, &options, &mut bytes, &mut memory, &mut work)?;
/// let expected = [4.0 - 5f64.sqrt(), 4.0 + 5f64.sqrt()];
/// for (found, expected) in assembly.report().eigenvalues.iter().zip(expected) {
///     assert!((found - expected).abs() < 1e-14);
/// }
///
/// // The joined body is a file like any other.
/// let mut lent = vec![0.0; Body::<f64>::len_for(assembly.file(), &BodyOptions::default())?];
/// let mut body = Body::<f64>::bind(assembly.file(), &BodyOptions::default(), &mut lent)?;
/// body.step()?;
///
/// // The first mass moved by 1 m, the spring between them pulls it back by 2 N.
/// let mut forces = [0.0];
/// assembly.forces_into(&[1.0, 0.0], &[], &mut forces)?;
/// assert!((assembly.reaction(0, &forces)?.force[0] + 2.0).abs() < 1e-14);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Assembly<'m> {
    parts: &'m [Part<'m>],
    joints: &'m [Joint<'m>],
    synthesis: Synthesis<'m>,
    bytes: &'m [u8],
    file: File<'m>,
    first_mode: usize,
    residual: bool,
    glue: Option<usize>,
    damping: (f64, bool),
}

impl<'m> Assembly<'m> {
    /// Memory to lend for these parts and joints. Reads ports and names; `O(modes + ports)`.
    ///
    /// # Errors
    /// [`AssemblyError`]: parts and joints that do not fit.
    pub fn sizes(
        parts: &[Part<'_>],
        joints: &[Joint<'_>],
        options: &AssemblyOptions<'_>,
    ) -> Result<AssemblySizes, AssemblyError> {
        let counts = Counts::of(parts, joints)?;
        let most = if counts.alike { 0 } else { counts.n_modes() };
        let first = parts.first().map_or("", |part| part.file.metadata().units);
        let metadata = metadata(parts, &counts, options, (first, 1.0, [0.0; 2]))?;
        let length = |ratios, rows| filled_len(&metadata, Sections::of(&counts, ratios, rows).inputs());
        let bytes = length(true, 0)?.max(length(false, most)?);
        let (memory, work) = (counts.memory_len(), counts.work_len().max(carry_work(counts.r)));
        Ok(AssemblySizes { bytes, memory, work, coordinates: counts.r, rows: counts.m })
    }

    /// Joins parts, and writes the joined file to `bytes`. Lends what [`Assembly::sizes`] says; `work` is
    /// free again afterwards. `O(m³ + m² r + r³ + nodes (m r + r²))` for `m` rows of joints and `r`
    /// coordinates.
    ///
    /// # Errors
    /// [`AssemblyError`]: ports that do not meet, joints that hold a motion twice, a body that moves without
    /// stiffness, memory that is too short.
    pub fn bind(
        parts: &'m [Part<'m>],
        joints: &'m [Joint<'m>],
        options: &AssemblyOptions<'_>,
        bytes: &'m mut [u8],
        memory: &'m mut [f64],
        work: &mut [f64],
    ) -> Result<Self, AssemblyError> {
        let counts = Counts::of(parts, joints)?;
        let (found, needed) = (memory.len(), counts.memory_len());
        if found < needed {
            return Err(AssemblyError::LentMemory { what: "numbers of memory", found, needed });
        }
        let (found, needed) = (work.len(), counts.work_len());
        if found < needed {
            return Err(AssemblyError::LentMemory { what: "numbers of work", found, needed });
        }
        let asked = (options.inertia, options.states);
        let synthesis = Synthesis::new((parts, joints), &counts, asked, memory, work)?;
        let of_work = short("numbers of work");
        let mut lender = Lender::new(work);
        let kept = lender.take(counts.damping_work()[0]).map_err(&of_work)?;
        let work = lender.rest();
        let damping = Damping::new(parts, &counts, &synthesis, kept, work)?;
        let first = synthesis.eigenvalues.get(counts.first_mode).copied().unwrap_or(1.0);
        let period = core::f64::consts::TAU / libm::sqrt(first);
        let time_step = options.time_step.unwrap_or_else(|| proposed_time_step(period));
        if !(time_step > 0.0 && time_step.is_finite()) {
            return Err(AssemblyError::Number { what: "the time step" });
        }
        let units = parts.first().map_or("", |part| part.file.metadata().units);
        let metadata = metadata(parts, &counts, options, (units, time_step, damping.rayleigh))?;

        let mut lender = Lender::new(work);
        let [rows, ports] = Inputs::len(&counts);
        let (rows, ports) = (lender.take(rows).map_err(&of_work)?, lender.take(ports).map_err(&of_work)?);
        let nodes = if counts.residual { 3 * counts.load_nodes * counts.m } else { 0 };
        let nodes = lender.take(nodes).map_err(&of_work)?;
        let scratch = lender.take(4 * counts.r + 3 * counts.m).map_err(&of_work)?;
        let inputs = Inputs::new(parts, &counts, &synthesis, [rows, ports], scratch)?;
        let residual = if counts.residual { Some(Residual::new(parts, &synthesis, nodes)) } else { None };
        let joined = Joined {
            parts,
            counts: &counts,
            synthesis: &synthesis,
            damping: &damping,
            inputs: &inputs,
            residual,
        };
        let dashpots = damping.rows.len().checked_div(counts.n_modes()).unwrap_or(0);
        let sections = Sections::of(&counts, damping.has_ratios, dashpots);
        let fill = |kind: SectionKind, place: &mut [u8]| joined.fill(kind, place, scratch);
        let (found, needed) = (bytes.len(), filled_len(&metadata, sections.inputs())?);
        if found < needed {
            return Err(AssemblyError::LentMemory { what: "bytes of the file", found, needed });
        }
        let length = encode_filled(&metadata, sections.inputs(), fill, bytes)?;
        let damping = (damping.coupling, !damping.rows.is_empty());
        let bytes: &'m [u8] = bytes;
        let bytes = bytes.get(..length).unwrap_or_default();
        Ok(Self {
            parts,
            joints,
            synthesis,
            bytes,
            file: File::parse(bytes)?,
            first_mode: counts.first_mode,
            residual: counts.residual,
            glue: counts.glued.then_some(counts.own_patterns),
            damping,
        })
    }

    /// The joined file.
    #[must_use]
    pub const fn file(&self) -> &File<'m> {
        &self.file
    }

    /// Its bytes.
    #[must_use]
    pub const fn bytes(&self) -> &'m [u8] {
        self.bytes
    }

    /// Its parts.
    #[must_use]
    pub const fn parts(&self) -> &'m [Part<'m>] {
        self.parts
    }

    /// Frequencies, kind of the synthesis, rows, damping.
    #[must_use]
    pub fn report(&self) -> AssemblyNumbers<'m> {
        AssemblyNumbers {
            eigenvalues: self.synthesis.eigenvalues.get(self.first_mode..).unwrap_or_default(),
            rubin: self.synthesis.rubin,
            rows: self.synthesis.rows.len(),
            distances: self.synthesis.distances,
            damping_coupling: self.damping.0,
            damping_coupled: self.damping.1,
            residual: self.residual,
            time_step: self.file.metadata().time_step,
        }
    }

    /// Coordinates of all parts, as many as the joined body has; the first six are rigid motions of a free
    /// body, as those of a [`Part`] of the joined file.
    #[must_use]
    pub const fn n_coordinates(&self) -> usize {
        self.synthesis.eigenvalues.len()
    }

    /// Coordinates that the modes of the file come after: 6 of a free body, else 0.
    #[must_use]
    pub const fn n_rigid(&self) -> usize {
        self.first_mode
    }

    /// The load pattern of joints that are made as they stand, or at offsets: the caller holds its amplitude
    /// at 1. `None` without such joints.
    #[must_use]
    pub const fn glue_pattern(&self) -> Option<usize> {
        self.glue
    }

    /// The state of the joined body from those of its parts: coordinates `η = YᵀM'q`, so that no displacement
    /// of a part jumps, and rates `η̇ = YᵀM'^½ q̇`, so that no kinetic energy does.
    ///
    /// Joined, what the modes of the parts leave out moves too, with the mass `M' − I`. Coordinates whose
    /// rates were kept would gain its kinetic energy; rates that keep the energy instead differ from them by
    /// half of that mass, and not at all in MacNeal's synthesis and in a motion of the body as a whole. Lends
    /// [`AssemblySizes::work`]; `O(r³)`.
    ///
    /// # Errors
    /// [`AssemblyError::Length`], [`AssemblyError::Number`], [`AssemblyError::LentMemory`].
    pub fn join(
        &self,
        states: &[PartState<'_>],
        displacement: &mut [f64],
        velocity: &mut [f64],
        work: &mut [f64],
    ) -> Result<(), AssemblyError> {
        carry::join(self.parts, &self.synthesis, states, [displacement, velocity], work)
    }

    /// The states of the parts from that of the joined body, one part after the other: `q = Y η` and
    /// `q̇ = M'^½ Y η̇`, the inverse of [`Assembly::join`]. Lends [`AssemblySizes::work`]; `O(r³)`.
    ///
    /// # Errors
    /// [`AssemblyError::Length`], [`AssemblyError::LentMemory`].
    pub fn part_states(
        &self,
        displacement: &[f64],
        velocity: &[f64],
        of_parts: &mut [f64],
        velocities: &mut [f64],
        work: &mut [f64],
    ) -> Result<(), AssemblyError> {
        carry::part_states(&self.synthesis, [displacement, velocity], [of_parts, velocities], work)
    }

    /// Forces of the rows of all joints, `f = −S⁻¹(Γq + G R F − g₀)`, on their first ports; `of_parts` are
    /// the coordinates of the parts, `port_motions` of each part what loads move of its ports
    /// ([`PartState`]), none without loads. `O(m² + m r)`.
    ///
    /// # Errors
    /// [`AssemblyError::Length`].
    pub fn forces_into(
        &self,
        of_parts: &[f64],
        port_motions: &[&[f64]],
        out: &mut [f64],
    ) -> Result<(), AssemblyError> {
        carry::forces(&self.synthesis, of_parts, port_motions, out)
    }

    /// Resultant of the forces of a joint on its first port about the port's origin, from those of all rows.
    /// The second port, or the ground, has the opposite.
    ///
    /// # Errors
    /// [`AssemblyError::Joint`] for a joint that there is not.
    pub fn reaction(&self, joint: usize, forces: &[f64]) -> Result<JointForce, AssemblyError> {
        carry::resultant((self.parts, self.joints), joint, forces, None)
    }

    /// [`Assembly::reaction`], and the force on each node of a first port that is a patch, three numbers each
    /// \[N\].
    ///
    /// # Errors
    /// As [`Assembly::reaction`]; [`AssemblyError::Length`].
    pub fn nodal_reaction_into(
        &self,
        joint: usize,
        forces: &[f64],
        nodal: &mut [f64],
    ) -> Result<JointForce, AssemblyError> {
        carry::resultant((self.parts, self.joints), joint, forces, Some(nodal))
    }

    /// Energy of the joints under their forces, and at rates `q̇` of the coordinates of the parts that move
    /// as joined, `Y η̇`.
    #[must_use]
    pub fn joint_energy(&self, forces: &[f64], rates: &[f64]) -> JointEnergy {
        carry::energy(&self.synthesis, forces, rates)
    }

    /// Offsets of the rows of a joint, for [`Joint::at`] in another assembly.
    ///
    /// # Errors
    /// [`AssemblyError::Joint`] for a joint that there is not.
    pub fn offsets(&self, joint: usize) -> Result<&'m [f64], AssemblyError> {
        let (first, count) = carry::joint_rows((self.parts, self.joints), joint)?;
        let unknown = AssemblyError::Joint { joint, fault: JointFault::Unknown };
        self.synthesis.offsets.get(first..first + count).ok_or(unknown)
    }
}

/// Metadata of the joined file.
fn metadata<'a>(
    parts: &[Part<'_>],
    counts: &Counts,
    options: &AssemblyOptions<'a>,
    (units, time_step, [alpha, beta]): (&'a str, f64, [f64; 2]),
) -> Result<Metadata<'a>, AssemblyError> {
    let count = |n: usize| {
        let most = FormatError::LentMemory { found: u64::from(u32::MAX), needed: n as u64 };
        u32::try_from(n).map_err(|_| most)
    };
    Ok(Metadata {
        program: options.program,
        problem: options.problem,
        units,
        mesh_hash: options.mesh_hash.unwrap_or_else(|| mesh_hash(parts)),
        n_nodes: count(counts.nodes)?,
        n_surface_nodes: count(counts.nodes)?,
        n_load_nodes: count(counts.load_nodes)?,
        n_triangles: count(counts.triangles)?,
        n_load_triangles: count(counts.load_triangles)?,
        n_modes: count(counts.n_modes())?,
        n_patterns: count(counts.patterns)?,
        n_probes: count(counts.probes)?,
        scheme_name: "exact",
        scheme: SchemeTable::EXACT,
        time_step,
        alpha,
        beta,
        n_regions: 1,
        n_parameters: 0,
        parameters: [Parameter::UNUSED; MAX_PARAMETERS],
        axes: [Axis::UNUSED; MAX_AXES],
        n_axes: 0,
        n_terms: 0,
        diagonal: true,
        block: false,
        certificate: Certificate::default(),
    })
}

/// A hash of the hashes and places of the parts.
fn mesh_hash(parts: &[Part<'_>]) -> [u8; 16] {
    let mut hash = [0u8; 16];
    for (index, part) in parts.iter().enumerate() {
        let own = part.file.metadata().mesh_hash;
        let mut place = [0u8; 96];
        let corners =
            [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|x| part.pose.place(x));
        let numbers = place.as_chunks_mut::<8>().0.iter_mut().zip(corners.as_flattened());
        numbers.for_each(|(to, x)| *to = x.to_le_bytes());
        let mark = checksum(&place).wrapping_add(index as u32).to_le_bytes();
        let mark = mark.iter().cycle();
        for ((to, from), mark) in hash.iter_mut().zip(own).zip(mark) {
            *to = to.rotate_left(1) ^ from ^ mark;
        }
    }
    hash
}

/// A step for a body of this first period \[s\]: the largest of 1, 2 and 5 times a power of ten that takes at
/// least 40 steps to the period.
fn proposed_time_step(first_period: f64) -> f64 {
    let step = first_period / STEPS_PER_PERIOD;
    let power = libm::floor(libm::log10(step));
    if !power.is_finite() || power.abs() > f64::from(EXACT_POWER) {
        return step;
    }
    // Powers that binary64 holds exactly give the nearest number to 5e−4 and its like.
    let mut ten = 1.0;
    for _ in 0..power.abs() as i32 {
        ten *= 10.0;
    }
    let round = [5.0, 2.0, 1.0].map(|digit| if power < 0.0 { digit / ten } else { digit * ten });
    round.into_iter().find(|round| *round <= step).unwrap_or(step)
}

#[cfg(test)]
mod tests {
    use super::proposed_time_step;

    #[test]
    fn a_proposed_step_is_round_and_takes_forty_steps_or_more() {
        assert_eq!(proposed_time_step(1.0), 0.02);
        assert_eq!(proposed_time_step(0.0399), 5e-4);
        assert_eq!(proposed_time_step(44.0), 1.0);
        for period in [1e-9, 3.7e-5, 0.04, 0.0401, 8.0, 1e6, 1e-60] {
            let steps = period / proposed_time_step(period);
            assert!((40.0 * (1.0 - 1e-15)..100.1).contains(&steps), "{period}: {steps}");
        }
    }
}
