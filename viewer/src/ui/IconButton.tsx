/** A small button with a tooltip. */

import type { ComponentChildren } from "preact";
import { Icon, type IconName } from "./icons";

interface IconButtonProps {
  /** For screen readers. */
  name: string;
  title: string;
  icon?: IconName;
  class?: string;
  pressed?: boolean;
  disabled?: boolean;
  onClick: () => void;
  children?: ComponentChildren;
}

export function IconButton({ name, icon, pressed, disabled, ...props }: IconButtonProps) {
  return (
    <button
      type="button"
      class={`icon-button ${props.class ?? ""}`}
      aria-label={name}
      aria-pressed={pressed}
      aria-disabled={disabled}
      title={props.title}
      onClick={props.onClick}
    >
      {icon ? <Icon name={icon} /> : props.children}
    </button>
  );
}
