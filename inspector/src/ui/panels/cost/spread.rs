//! How a cost is spread over rays: a histogram, mean, median, the 95th percentile, and the largest; and in a sentence.

use raystep_lab::human::{digits, grouped};
use raystep_lab::work::CostOrder;

use super::scale::Scale;

/// Bars of a histogram at most.
const BINS: usize = 64;

/// Rays are few if they are a smaller share than this of all.
const FEW: f64 = 0.25;

/// A histogram: bar `i` counts rays that cost from `edges[i]` to less than `edges[i + 1]`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Bins {
    pub(super) edges: Vec<u32>,
    pub(super) counts: Vec<u64>,
}

impl Bins {
    /// `costs` descending.
    fn new(costs: impl Iterator<Item = u32>, most: u32, is_log: bool) -> Self {
        let scale = Scale { is_log, ..Scale::default() };
        let mut edges: Vec<u32> = if is_log {
            (0..BINS).map(|i| scale.value(i as f64 / BINS as f64, most)).collect()
        } else {
            let width = (u64::from(most) + 1).div_ceil(BINS as u64);
            (0..BINS as u64).map(|i| i * width).filter_map(|edge| u32::try_from(edge).ok()).collect()
        };
        edges.retain(|&edge| edge <= most);
        edges.dedup();
        let mut counts = vec![0; edges.len()];
        for cost in costs {
            if let Some(bin) = edges.partition_point(|&edge| edge <= cost).checked_sub(1) {
                counts[bin] += 1;
            }
        }
        Self { edges, counts }
    }

    /// The costs of a bar: the lowest, and the highest if the largest of all is `most`.
    pub(super) fn range(&self, bin: usize, most: u32) -> Option<[u32; 2]> {
        let from = *self.edges.get(bin)?;
        Some([from, self.edges.get(bin + 1).map_or(most, |next| next - 1)])
    }

    /// The bar of a cost.
    pub(super) fn of(&self, cost: u32) -> Option<usize> {
        self.edges.partition_point(|&edge| edge <= cost).checked_sub(1)
    }
}

/// Statistics of the cost of all rays.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Spread {
    pub(super) mean: f64,
    pub(super) median: u32,
    /// 95% of rays cost at most this.
    pub(super) most_of_95: u32,
    pub(super) most: u32,
    least: u32,
    rays: usize,
    /// The fewest rays that have half of the cost.
    half: usize,
    /// On a linear and on a logarithmic axis.
    bins: [Bins; 2],
}

impl Spread {
    pub(super) fn new(order: &CostOrder) -> Self {
        let rays = order.rays();
        let costs = || rays.iter().map(|&ray| order.cost(ray as usize).unwrap_or(0));
        // Nearest rank, in an order that descends.
        let at_most = |share: f64| {
            let rank = (share * rays.len() as f64).ceil().max(1.0) as usize;
            rays.len().checked_sub(rank).and_then(|at| costs().nth(at)).unwrap_or(0)
        };
        let most = costs().next().unwrap_or(0);
        Self {
            least: costs().next_back().unwrap_or(0),
            rays: rays.len(),
            half: order.half(),
            mean: order.total() as f64 / rays.len().max(1) as f64,
            median: at_most(0.5),
            most_of_95: at_most(0.95),
            most,
            bins: [false, true].map(|is_log| Bins::new(costs(), most, is_log)),
        }
    }

    /// What was found, and whether it matters. `unit`: what is counted.
    pub(super) fn sentence(&self, unit: &str) -> String {
        let Self { rays, least, most, median, half, .. } = *self;
        let cost = grouped(u64::from(most));
        match rays {
            0 => return "There are no rays, and no cost.".into(),
            _ if most == 0 => return format!("No ray costs anything: 0 {unit}."),
            1 => return format!("The only ray costs {cost} {unit}."),
            _ if least == most => return format!("Every ray costs the same: {cost} {unit}."),
            _ => {}
        }
        let share = half as f64 / rays as f64;
        let few = if share < FEW { "A few rays dominate the cost" } else { "Cost is spread over many rays" };
        let percent = match 100.0 * share {
            percent if percent < 1.0 => digits(percent),
            percent => format!("{percent:.0}"),
        };
        let times = match f64::from(most) / f64::from(median) {
            _ if median == 0 => "while at least half of the rays cost nothing".into(),
            times if times < 10.0 => format!("{times:.1} times the median"),
            times => format!("{} times the median", digits(times)),
        };
        format!("{few}: half of it is in {percent}% of rays. The most expensive ray costs {cost} {unit}, {times}.")
    }

    pub(super) fn bins(&self, is_log: bool) -> &Bins {
        &self.bins[usize::from(is_log)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ray_is_in_the_bar_of_its_cost() {
        let costs: Vec<u32> = (0..1000).map(|i| i * i % 977).collect();
        let spread = Spread::new(&CostOrder::new(costs.clone()));
        for is_log in [false, true] {
            let bins = spread.bins(is_log);
            assert!(bins.edges.len() <= BINS && bins.edges[0] == 0 && bins.edges.is_sorted());
            assert_eq!(bins.counts.iter().sum::<u64>(), 1000);
            for &cost in &costs {
                let [from, to] = bins.range(bins.of(cost).expect("a bar"), spread.most).expect("a bar");
                assert!((from..=to).contains(&cost), "{cost} in {from} to {to}");
            }
        }
    }

    #[test]
    fn percentiles_are_those_of_the_nearest_rank() {
        let spread = Spread::new(&CostOrder::new((1..=100).collect()));
        assert_eq!((spread.median, spread.most_of_95, spread.most, spread.mean), (50, 95, 100, 50.5));
        let one = Spread::new(&CostOrder::new(vec![7]));
        assert_eq!((one.median, one.most_of_95, one.most, one.mean), (7, 7, 7, 7.0));
        assert_eq!(Spread::new(&CostOrder::new(Vec::new())).most, 0);
        let free = Spread::new(&CostOrder::new(vec![0; 9]));
        assert_eq!((free.bins(false).counts.as_slice(), free.bins(true).counts.as_slice()), (&[9][..], &[9][..]));
    }

    #[test]
    fn a_sentence_says_what_was_found_and_whether_it_matters() {
        let of = |costs: &[u32]| Spread::new(&CostOrder::new(costs.to_vec())).sentence("cells");
        assert_eq!(of(&[]), "There are no rays, and no cost.");
        assert_eq!(of(&[0; 5]), "No ray costs anything: 0 cells.");
        assert_eq!(of(&[1234]), "The only ray costs 1,234 cells.");
        assert_eq!(of(&[0]), "No ray costs anything: 0 cells.");
        assert_eq!(of(&[7; 4]), "Every ray costs the same: 7 cells.");
        // 40 of 80 is in 1 of 21 rays, the median is 2.
        let one_dear: Vec<u32> = (0..21).map(|i| if i == 3 { 40 } else { 2 }).collect();
        assert_eq!(
            of(&one_dear),
            "A few rays dominate the cost: half of it is in 5% of rays. The most expensive ray costs 40 cells, 20 times the median."
        );
        assert_eq!(
            of(&[4, 5, 6, 5]),
            "Cost is spread over many rays: half of it is in 50% of rays. The most expensive ray costs 6 cells, 1.2 times the median."
        );
        let mut rare = vec![0; 999];
        rare.push(3);
        assert_eq!(
            of(&rare),
            "A few rays dominate the cost: half of it is in 0.1% of rays. The most expensive ray costs 3 cells, while at least half of \
             the rays cost nothing."
        );
    }
}
