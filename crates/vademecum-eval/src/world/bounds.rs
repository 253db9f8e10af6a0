//! Boxes over the triangles of a surface at rest, and the extents of its modes in each.
//!
//! A box of the moving surface is the box at rest and `Σ_k |q_k| e_k` on each side, where `e_k` is the
//! largest displacement of mode `k` at a node of the box: a bound of what the box may hold, for `O(r)` and
//! without a look at its nodes.

use core::cell::Cell;

use crate::base::lend::Short;
use crate::base::scalar::Scalar;
use crate::body::tree::{LEAF, WAITING, leaf_at, n_boxes, place_of_leaf, sort_along_curve};
use crate::world::member::Outline;

/// Lower and upper corner.
pub(crate) type Corners = [[f64; 3]; 2];

/// Numbers of the pieces of a tree over `n` triangles with `r` modes: order and keys, boxes, extents.
pub(crate) const fn sizes(n: usize, r: usize) -> [usize; 3] {
    let boxes = n_boxes(n);
    [n.saturating_mul(4), boxes.saturating_mul(6), boxes.saturating_mul(3).saturating_mul(r)]
}

/// A tree of boxes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds<'a> {
    pub order: &'a [u32],
    pub boxes: &'a [[f32; 6]],
    /// Three numbers for each mode of each box.
    pub extents: &'a [f32],
    pub r: usize,
    /// Boxes as the surface has moved, and the steps they are of.
    pub moved: &'a [Cell<[f32; 6]>],
    pub fresh: &'a [Cell<u32>],
    pub step: u32,
}

/// Builds a tree over `outline`; `displacement` gives component `c` of mode `k` at a node.
pub(crate) fn build(
    outline: &Outline<'_>,
    r: usize,
    displacement: impl Fn(u32, usize, usize) -> f64,
    (order, boxes, extents): (&mut [u32], &mut [[f32; 6]], &mut [f32]),
) -> Result<(), Short> {
    let n = outline.n_triangles();
    let (order_len, found) = (4 * n, order.len());
    let order = order.get_mut(..order_len).ok_or(Short { found, needed: order_len })?;
    let centre = |triangle: usize| {
        let [a, b, c] = outline.triangle(triangle)?.map(|node| outline.node(node));
        let (a, b, c) = (a?, b?, c?);
        Some(core::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0))
    };
    let (order, spare) = order.split_at_mut(n);
    let (keys, spare) = spare.split_at_mut(n);
    let (other, other_keys) = spare.split_at_mut(n);
    sort_along_curve(centre, order, keys, other, other_keys);
    let leaves = n.div_ceil(LEAF);
    extents.fill(0.0);
    for (leaf, triangles) in order.chunks(LEAF).enumerate() {
        let at = place_of_leaf(leaf, leaves);
        let mut corners = [
            f32::INFINITY,
            f32::INFINITY,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NEG_INFINITY,
            f32::NEG_INFINITY,
        ];
        for node in triangles.iter().filter_map(|&t| outline.triangle(t as usize)).flatten() {
            let rest = outline.node(node).unwrap_or_default();
            for (k, x) in rest.into_iter().enumerate() {
                // Rounded outwards.
                let away = 1e-6 * x.abs();
                corners[k] = corners[k].min((x - away) as f32);
                corners[3 + k] = corners[3 + k].max((x + away) as f32);
            }
            let own = extents.chunks_exact_mut(3 * r.max(1)).nth(at);
            for (k, extent) in own.into_iter().flat_map(|own| own.as_chunks_mut::<3>().0).enumerate() {
                for (c, extent) in extent.iter_mut().enumerate() {
                    *extent = extent.max(1.000_001 * displacement(node, k, c).abs() as f32);
                }
            }
        }
        if let Some(place) = boxes.get_mut(at) {
            *place = corners;
        }
    }
    for i in (0..leaves.saturating_sub(1)).rev() {
        let (above, below) = boxes.split_at_mut(2 * i + 1);
        if let (Some(place), [a, b, ..]) = (above.get_mut(i), below) {
            *place = core::array::from_fn(|k| if k < 3 { a[k].min(b[k]) } else { a[k].max(b[k]) });
        }
        let width = 3 * r;
        let (above, below) = extents.split_at_mut(((2 * i + 1) * width).min(extents.len()));
        let children = below.iter().zip(below.iter().skip(width));
        for (place, (a, b)) in above.iter_mut().skip(i * width).zip(children).take(width) {
            *place = a.max(*b);
        }
    }
    Ok(())
}

impl Bounds<'_> {
    /// Box `i` of the surface as it has moved by `q`, with a margin. Computed once a step.
    pub fn corners<T: Scalar>(&self, i: usize, q: &[T], margin: f64) -> Option<Corners> {
        let (cell, fresh) = (self.moved.get(i)?, self.fresh.get(i)?);
        if fresh.get() != self.step {
            let around = *self.boxes.get(i)?;
            let extents = self.extents.get(3 * self.r * i..)?;
            let mut reach = [0.0_f32; 3];
            for (extent, q) in extents.as_chunks::<3>().0.iter().zip(q).take(self.r) {
                let size = q.magnitude().to_f64() as f32;
                reach.iter_mut().zip(extent).for_each(|(reach, &extent)| *reach += size * extent);
            }
            // Rounding of the sum, outwards.
            let reach = reach.map(|reach| 1.000_01 * reach);
            let (low, high) = (|k: usize| around[k] - reach[k], |k: usize| around[3 + k] + reach[k]);
            cell.set([low(0), low(1), low(2), high(0), high(1), high(2)]);
            fresh.set(self.step);
        }
        let [a, b, c, d, e, f] = cell.get().map(f64::from);
        let margin = margin + 1e-6 * (a.abs() + b.abs() + c.abs() + d.abs() + e.abs() + f.abs());
        Some([[a - margin, b - margin, c - margin], [d + margin, e + margin, f + margin]])
    }

    /// Hands out the triangles of the boxes that overlap `target`.
    pub fn visit<T: Scalar>(&self, q: &[T], margin: f64, target: &Corners, mut found: impl FnMut(u32)) {
        let leaves = self.order.len().div_ceil(LEAF);
        let mut waiting = [0_usize; WAITING];
        let mut count = usize::from(leaves > 0);
        while let Some(&i) = count.checked_sub(1).and_then(|last| waiting.get(last)) {
            count -= 1;
            let corners = self.corners(i, q, margin);
            if !corners.is_some_and(|corners| overlap(&corners, target)) {
                continue;
            }
            if i + 1 < leaves {
                for child in [2 * i + 2, 2 * i + 1] {
                    if let Some(place) = waiting.get_mut(count) {
                        *place = child;
                        count += 1;
                    }
                }
                continue;
            }
            self.order
                .iter()
                .skip(LEAF * leaf_at(i, leaves))
                .take(LEAF)
                .for_each(|&triangle| found(triangle));
        }
    }
}

/// `true` if two boxes share a point.
pub(crate) fn overlap(a: &Corners, b: &Corners) -> bool {
    (0..3).all(|k| a[0][k] <= b[1][k] && b[0][k] <= a[1][k])
}
