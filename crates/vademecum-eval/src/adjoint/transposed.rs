//! A scene with the transposed map of its step, and the transposed load maps.

use crate::base::lend::{Lender, Short, put};
use crate::base::scalar::Scalar;
use crate::kernels::kernel::{LANES, TILE};
use crate::scene::bind::place_in_tiles;
use crate::scene::scene::Scene;

impl<'m, T: Scalar> Scene<'m, T> {
    /// The scene whose step is the transpose of this one's, of exact steps; it has no loads of its own. Lends
    /// as many numbers as the map has.
    pub(crate) fn transposed<'n>(&self, map: &'n mut [T]) -> Result<Scene<'n, T>, Short>
    where
        'm: 'n,
    {
        let n = 2 * self.shape.r;
        if self.shape.is_coupled() {
            map.fill(T::ZERO);
            for row in 0..n {
                for column in 0..n {
                    let from = place_in_tiles(row, column, n);
                    let value = self.map.get(from).copied().unwrap_or(T::ZERO);
                    put(map, place_in_tiles(column, row, n), value)?;
                }
            }
        } else {
            map.iter_mut().zip(&*self.map).for_each(|(to, &from)| *to = from);
            for block in map.as_chunks_mut::<LANES>().0.as_chunks_mut::<2>().0.as_chunks_mut::<2>().0 {
                let [[_, upper], [lower, _]] = block;
                core::mem::swap(upper, lower);
            }
        }
        Ok(Scene {
            shape: self.shape,
            metadata: self.metadata,
            options: self.options,
            parameters: self.parameters,
            sections: self.sections,
            generation: self.generation,
            rest_below: T::ZERO,
            filter: self.filter,
            strain: self.strain,
            map,
            load_maps: &mut [],
            weights: &mut [],
        })
    }

    /// `Lᵀ λ` of the load maps for the start and for the end of a step, of exact steps: `out` has `r` numbers
    /// for each, cotangents have the layout of a state.
    pub(crate) fn loads_of_cotangents(&self, cotangents: &[T], out: &mut [T]) -> Result<(), Short> {
        let (r, stride) = (self.shape.r.max(1), self.shape.stride().max(1));
        let mut maps = Lender::new(&*self.load_maps);
        for out in out.chunks_exact_mut(r).take(2) {
            let map = maps.take(self.shape.load_map_len())?;
            out.fill(T::ZERO);
            if self.shape.is_coupled() {
                let tiles = map.as_chunks::<TILE>().0.chunks_exact(r);
                for (tile, own) in tiles.zip(cotangents.as_chunks::<TILE>().0) {
                    for (out, column) in out.iter_mut().zip(tile) {
                        for (&a, &b) in column.iter().zip(own) {
                            *out += a * b;
                        }
                    }
                }
                continue;
            }
            for (map, own) in map.chunks_exact(stride).zip(cotangents.chunks_exact(stride)) {
                out.iter_mut().zip(map).zip(own).for_each(|((out, &a), &b)| *out += a * b);
            }
        }
        Ok(())
    }
}
