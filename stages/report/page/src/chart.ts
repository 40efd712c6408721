// Curves in the colours of the page.
import uPlot from "uplot";

export type Curve = { label: string; values: (number | null)[]; light: string; dark: string; stepped?: boolean; dots?: boolean };

/** Draws curves over x into `place`, as wide as it is. */
export function drawChart(place: HTMLElement, x: { label: string; values: number[] }, yLabel: string, curves: Curve[], logarithmic = false) {
  const dark = document.documentElement.classList.contains("dark");
  const ink = dark ? "#e9ebef" : "#16181d", line = { stroke: dark ? "#3b414b" : "#dde0e5", width: 1 };
  const axis = (label: string, size: number) => ({ label, stroke: ink, grid: line, ticks: line, size, labelSize: 18, labelGap: 0, font: "12px system-ui", labelFont: "12px system-ui" });
  const stepped = uPlot.paths.stepped!({ align: 1 });
  new uPlot({
    width: Math.max(240, place.clientWidth - 4), height: 180,
    scales: { x: { time: false }, y: { distr: logarithmic ? 3 : 1 } },
    axes: [axis(x.label, 34), { ...axis(yLabel, 52), space: 30 }],
    series: [{ label: x.label }, ...curves.map((c) => ({
      label: c.label, stroke: dark ? c.dark : c.light, width: c.dots ? 4 : 2,
      ...(c.stepped ? { paths: stepped } : {}), ...(c.dots ? { points: { show: true, size: 9 } } : {}),
    }))],
  }, [x.values, ...curves.map((c) => c.values)], place);
}
