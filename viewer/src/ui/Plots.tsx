/** f in the plane of incidence, and the directional albedo. */

import { useRef } from "preact/hooks";
import { ALBEDO_ANGLES, PLANE_ANGLES, type Slot } from "../engine/engine";
import { session } from "../engine/session";
import { COLOURS } from "../material/channels";
import { look, state } from "../state/store";
import { valueByKey } from "./Slider";

export function Plots() {
  const slot = session.value?.slots[state.value.active];
  return (
    <section class="plots" aria-label="Plots">
      <details
        open={state.value.plots}
        onToggle={({ currentTarget: element }) => {
          const { open: plots } = element;
          if (plots === state.value.plots) return;
          look({ plots });
          if (plots) element.scrollIntoView({ block: "nearest" });
        }}
      >
        <summary>Plots</summary>
        <div>
          <PlanePlot slot={slot} />
          <AlbedoPlot slot={slot} />
        </div>
      </details>
    </section>
  );
}

type Point = [x: number, y: number];

interface CurvesProps {
  /** [degrees] */
  angles: Float32Array;
  /** (angles, 3); null: they are not known yet. */
  values: Float32Array | null;
  place: (degrees: number, value: number) => Point;
}

/** The curves of the channels. */
function Curves({ angles, values, place }: CurvesProps) {
  if (values === null) return null;
  const point = (degrees: number, value: number) =>
    place(degrees, value)
      .map((x) => x.toFixed(1))
      .join(" ");
  return COLOURS.map((channel, k) => {
    const points = Array.from(angles, (degrees, at) => point(degrees, values[3 * at + k]));
    return <path key={channel} class={`curve ${channel}`} d={`M${points.join("L")}`} />;
  });
}

/** The plot's half circle. */
const RADIUS = 120;

/** f at the circle: rings at powers of ten. */
function scaleOf(f: Float32Array | null): { radius: (f: number) => number; rings: number[] } {
  const most = Math.max(1, ...(f ?? []));
  const top = 10 ** Math.ceil(Math.log10(most) - 0.02);
  const floor = 0.01;
  const radius = (x: number) =>
    (RADIUS * Math.log(1 + Math.max(x, 0) / floor)) / Math.log(1 + top / floor);
  const rings = [];
  for (let ring = top; ring > 0.05; ring /= 10) rings.push(Number(ring.toPrecision(1)));
  return { radius, rings };
}

function PlanePlot({ slot }: { slot: Slot | undefined }) {
  const svg = useRef<SVGSVGElement>(null);
  const handle = useRef<SVGCircleElement>(null);
  const held = useRef(false);
  const { incidence } = state.value;
  const f = slot?.plane.value ?? null;
  const { radius, rings } = scaleOf(f);
  const at = (degrees: number, r: number): Point => {
    const angle = (degrees * Math.PI) / 180;
    return [r * Math.sin(angle), -r * Math.cos(angle)];
  };
  const [x, y] = at(-incidence, RADIUS);

  const follow = (event: PointerEvent) => {
    const matrix = svg.current?.getScreenCTM();
    if (!matrix) return;
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    const degrees = (Math.atan2(-at.x, Math.max(-at.y, 0)) * 180) / Math.PI;
    look({ incidence: Math.round(Math.min(Math.max(degrees, 0), 89)) });
  };
  return (
    <figure>
      <figcaption>
        <b>f in the plane of incidence</b> [1/sr]
      </figcaption>
      <svg
        ref={svg}
        viewBox="-150 -136 300 152"
        role="group"
        aria-label="Plot of f in the plane of incidence"
        onPointerDown={(event) => {
          // Elsewhere than on the handle, a touch scrolls the page.
          held.current = event.pointerType !== "touch" || event.target === handle.current;
          if (!held.current) return;
          event.currentTarget.setPointerCapture(event.pointerId);
          follow(event);
        }}
        onPointerMove={(event) => {
          if (held.current) follow(event);
        }}
        onLostPointerCapture={() => {
          held.current = false;
        }}
      >
        <g class="grid">
          {rings.map((ring) => (
            <g key={ring}>
              <path d={halfCircle(radius(ring))} />
              <text x={radius(ring) - 2} y={11} text-anchor="end">
                {ring}
              </text>
            </g>
          ))}
          <path d={`M${-RADIUS} 0H${RADIUS}M0 0V${-RADIUS}`} />
        </g>
        <Curves
          angles={PLANE_ANGLES}
          values={f}
          place={(degrees, value) => at(degrees, radius(value))}
        />
        <line class="incident" x1={0} y1={0} x2={x} y2={y} />
        <circle class="knob" cx={x} cy={y} r={7} />
        <circle
          ref={handle}
          class="handle"
          cx={x}
          cy={y}
          r={14}
          tabindex={0}
          role="slider"
          aria-label="Angle of incidence"
          aria-valuemin={0}
          aria-valuemax={89}
          aria-valuenow={incidence}
          aria-valuetext={`${incidence} degrees`}
          onKeyDown={(event) => {
            // The direction of the light lies on the left.
            const next = valueByKey(event, incidence, event.shiftKey ? -10 : -1, 0, 89);
            if (next !== undefined) look({ incidence: next });
          }}
        />
        <text class="value" x={x < -60 ? x + 4 : x - 12} y={y - 11} text-anchor="middle">
          {incidence}°
        </text>
      </svg>
    </figure>
  );
}

function halfCircle(radius: number): string {
  const r = radius.toFixed(1);
  return `M-${r} 0A${r} ${r} 0 0 1 ${r} 0`;
}

const WIDTH = 230;
const HEIGHT = 104;

function AlbedoPlot({ slot }: { slot: Slot | undefined }) {
  const albedo = slot?.albedo.value ?? null;
  const { incidence } = state.value;
  const across = (degrees: number) => (WIDTH * degrees) / 90;
  return (
    <figure>
      <figcaption>
        <b>Directional albedo</b> by angle of incidence
      </figcaption>
      <svg viewBox="-34 -14 280 142" role="img" aria-label={spokenAlbedo(albedo)}>
        <g class="grid">
          {[0, 0.25, 0.5, 0.75, 1].map((value) => (
            <path key={value} d={`M0 ${HEIGHT * (1 - value)}H${WIDTH}`} />
          ))}
          {[0, 0.5, 1].map((value) => (
            <text key={value} x={-6} y={HEIGHT * (1 - value) + 3} text-anchor="end">
              {value}
            </text>
          ))}
          {[0, 30, 60, 90].map((degrees) => (
            <text key={degrees} x={across(degrees)} y={HEIGHT + 15} text-anchor="middle">
              {degrees}°
            </text>
          ))}
        </g>
        <line class="incident" x1={across(incidence)} x2={across(incidence)} y1={0} y2={HEIGHT} />
        <Curves
          angles={ALBEDO_ANGLES}
          values={albedo}
          place={(degrees, value) => [across(degrees), HEIGHT * (1 - Math.min(value, 1.1))]}
        />
      </svg>
    </figure>
  );
}

function spokenAlbedo(albedo: Float32Array | null): string {
  if (albedo === null) return "Directional albedo";
  const percent = (at: number) =>
    [0, 1, 2].map((k) => `${Math.round(100 * albedo[3 * at + k])}`).join(", ");
  return `Directional albedo in percent, red, green and blue: ${percent(0)} near the normal, ${percent(13)} at grazing incidence`;
}
