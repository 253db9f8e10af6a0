# The vademecum file, version 1, for Kaitai Struct (https://kaitai.io). The normative text is vademecum-1.md beside this file; numbers,
# names and order are the same. Checksums are not computed here, and compressed sections are given as their stored bytes.
meta:
  id: vademecum_1
  title: Vademecum of a solid, version 1
  file-extension: vdm
  endian: le
  encoding: UTF-8
  license: MIT OR Apache-2.0
seq:
  - id: header
    type: header
  - id: directory
    type: entry
    repeat: expr
    repeat-expr: header.n_sections
instances:
  metadata:
    pos: header.metadata_offset
    size: header.metadata_length
    type: metadata
types:
  header:
    seq:
      - id: magic
        contents: [0x89, 0x56, 0x44, 0x4d, 0x0d, 0x0a, 0x1a, 0x0a]
      - id: major
        type: u2
        valid: 1
      - id: minor
        type: u2
      - id: n_sections
        type: u4
        valid:
          max: 256
      - id: file_length
        type: u8
      - id: metadata_offset
        type: u8
        valid: 64 * (1 + n_sections)
      - id: metadata_length
        type: u8
        valid:
          max: 1048576
      - id: metadata_crc32
        type: u4
      - id: directory_crc32
        type: u4
      - id: zero
        contents: [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]
      - id: header_crc32
        type: u4
  entry:
    seq:
      - id: kind
        type: u4
        enum: kind
      - id: element
        type: u1
        enum: element
      - id: codec
        type: u1
        enum: codec
      - id: flags
        type: u2
      - id: shape
        type: u8
        repeat: expr
        repeat-expr: 3
      - id: offset
        type: u8
      - id: stored_length
        type: u8
      - id: decoded_length
        type: u8
      - id: crc32
        type: u4
      - id: zero
        type: u4
        valid: 0
    instances:
      required:
        value: (flags & 1) == 1
      stored:
        io: _root._io
        pos: offset
        size: stored_length
      blocks:
        io: _root._io
        pos: offset
        size: stored_length
        type: blocks(decoded_length)
        if: codec == codec::shuffled or codec == codec::delta
      # By the type of its numbers; absent where the section is compressed.
      numbers:
        io: _root._io
        pos: offset
        size: stored_length
        if: codec == codec::raw
        type:
          switch-on: element
          cases:
            'element::u8': u8s
            'element::u32': u32s
            'element::u64': u64s
            'element::f32': f32s
            'element::f64': f64s
            'element::i16': quantised((shape[0] + 127) / 128 * shape[1] * shape[2])
  u8s:
    seq:
      - id: values
        type: u1
        repeat: eos
  u32s:
    seq:
      - id: values
        type: u4
        repeat: eos
  u64s:
    seq:
      - id: values
        type: u8
        repeat: eos
  f32s:
    seq:
      - id: values
        type: f4
        repeat: eos
  f64s:
    seq:
      - id: values
        type: f8
        repeat: eos
  quantised:
    doc: Number (i, c) is integer (i, c) times scale (i / 128, c).
    params:
      - id: n_scales
        type: u8
    seq:
      - id: scales
        type: f4
        repeat: expr
        repeat-expr: n_scales
      - id: integers
        type: s2
        repeat: eos
  blocks:
    doc: A section coded by block; each frame ends where the table says, counted from the end of the table.
    params:
      - id: decoded_length
        type: u8
    seq:
      - id: block_length
        type: u8
        doc: A multiple of 8.
        valid:
          min: 8
          max: 1048576
      - id: ends
        type: u8
        repeat: expr
        repeat-expr: (decoded_length + block_length - 1) / block_length
  text:
    seq:
      - id: length
        type: u8
      - id: value
        type: str
        size: length
  metadata:
    seq:
      - id: program
        type: text
      - id: problem
        type: text
      - id: units
        type: text
      - id: mesh_hash
        size: 16
      - id: n_nodes
        type: u4
      - id: n_surface_nodes
        type: u4
      - id: n_load_nodes
        type: u4
      - id: n_triangles
        type: u4
      - id: n_load_triangles
        type: u4
      - id: n_modes
        type: u4
      - id: n_patterns
        type: u4
      - id: n_probes
        type: u4
      - id: scheme_name
        type: text
      - id: scheme
        type: scheme
      - id: time_step
        type: f8
        doc: s
      - id: alpha
        type: f8
        doc: 1/s
      - id: beta
        type: f8
        doc: s
      - id: n_regions
        type: u4
      - id: n_parameters
        type: u4
      - id: parameters
        type: parameter
        repeat: expr
        repeat-expr: 16
      - id: axes
        type: axis
        repeat: expr
        repeat-expr: 12
      - id: n_axes
        type: u4
      - id: n_terms
        type: u4
      - id: diagonal
        type: u1
        valid:
          max: 1
      - id: block
        type: u1
        valid:
          max: 1
      - id: certificate_of_diagonal
        type: certificate
      - id: certificate_of_block
        type: certificate
  scheme:
    seq:
      - id: n_stages
        type: u1
        doc: 0 means exact steps of the modes; all numbers below are then zero.
        valid:
          max: 3
      - id: stages
        type: stage
        repeat: expr
        repeat-expr: 3
      - id: finish
        type: f8
        repeat: expr
        repeat-expr: 18
        doc: three rows of six, the new u, dt u', dt² u''
  stage:
    seq:
      - id: mass
        type: f8
      - id: damping
        type: f8
      - id: stiffness
        type: f8
      - id: time
        type: f8
      - id: load
        type: f8
        repeat: expr
        repeat-expr: 4
      - id: mass_history
        type: f8
        repeat: expr
        repeat-expr: 6
      - id: damping_history
        type: f8
        repeat: expr
        repeat-expr: 6
      - id: stiffness_history
        type: f8
        repeat: expr
        repeat-expr: 6
  parameter:
    seq:
      - id: name
        type: text
      - id: unit
        type: text
      - id: role
        type: u4
        enum: parameter_role
      - id: region
        type: u4
        if: role == parameter_role::region_stiffness or role == parameter_role::region_density
      - id: log
        type: u1
      - id: lower
        type: f8
      - id: upper
        type: f8
      - id: nominal
        type: f8
  axis:
    seq:
      - id: name
        type: text
      - id: unit
        type: text
      - id: role
        type: u4
        enum: axis_role
      - id: monomial
        type: monomial
        if: role == axis_role::monomial
      - id: kind
        type: u4
        enum: axis_kind
      - id: log
        type: u1
      - id: lower
        type: f8
      - id: upper
        type: f8
      - id: n_points
        type: u4
  monomial:
    seq:
      - id: theta
        type: f8
      - id: stiffness
        type: f8
        repeat: expr
        repeat-expr: 8
      - id: density
        type: f8
        repeat: expr
        repeat-expr: 8
  certificate:
    doc: NaN where nothing was measured.
    seq:
      - id: trajectory_error
        type: f8
      - id: projection_floor
        type: f8
      - id: spectral_radius
        type: f8
      - id: energy_ratio
        type: f8
      - id: map_error_rms
        type: f8
      - id: map_error_max
        type: f8
      - id: steps
        type: f8
enums:
  kind:
    1: node_ids
    2: node_coordinates
    3: triangles
    4: reduced_stiffness
    5: eigenvalues
    6: surface_basis
    7: interior_basis
    8: block_state
    9: block_load
    10: pattern_basis
    11: pattern_block
    12: pattern_names
    13: probe_names
    14: probe_rows
    15: singular_values
    16: mode_table
    17: axis_points
    18: factors
    19: region_stiffness
    20: region_mass
    21: enrichment_history
    22: radius_samples
    23: canonical_parts
    24: canonical_axes
    25: canonical_factors
    26: canonical_terms
    27: canonical_positions
    28: canonical_direction
    29: canonical_certificate
    30: losses
    31: repairs
    32: structure_figures
    33: damping_ratios
    34: contact_residual
    35: residual_pairs
    36: pair_residual
    37: probe_residual
    38: pattern_residual
    39: pattern_probe_residual
    42: factor_order
    43: factor_groups
    44: factor_rows
    45: factor_values
    46: pattern_answer
    47: stress_points
    48: stress_basis
    49: stress_residual
    50: pattern_stress
    51: elastic_constants
    52: probe_units
    53: support_names
    54: support_points
    55: reaction_basis
    56: reaction_loads
    57: pattern_reaction
    58: base_frame
    59: rigid_body
    60: strain_sizes
    61: strain_linear
    62: strain_tail
    63: strain_quadratic
    64: strain_box
    65: strain_limits
    66: strain_modes
    67: mesh_error
    75: compliance
    76: embedded_nodes
    77: embedded_weights
    78: embedded_triangles
    79: damping_rows
    80: quadrangles
    95: port_names
    96: port_table
    97: port_frames
    98: port_nodes
    99: port_facets
    100: port_rows
    101: port_compliance
    102: port_inertia
    103: port_residual
    104: port_probes
    105: port_patterns
    106: probe_motions
    107: contact_modes
    108: patch_pairs
    109: patch_residual
    110: contact_patch
    40: static_bound
    41: bound_map
  element:
    0: u8
    1: u32
    2: u64
    3: f32
    4: f64
    5: i16
  codec:
    0: raw
    1: zstd
    2: shuffled
    3: delta
  parameter_role:
    0: stiffness
    1: region_stiffness
    2: density
    3: region_density
    4: alpha
    5: beta
    6: time_step
  axis_role:
    0: stage
    1: monomial
  axis_kind:
    0: index
    1: hat
    2: chebyshev
