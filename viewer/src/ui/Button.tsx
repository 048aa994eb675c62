/** Buttons: with a text, or small ones with an icon. */

import type { ButtonHTMLAttributes } from "preact";
import { Icon, type IconName } from "./icons";

export function Button(props: ButtonHTMLAttributes) {
  return <button type="button" {...props} />;
}

interface IconButtonProps extends ButtonHTMLAttributes {
  /** For screen readers. */
  name: string;
  /** The tooltip. */
  title: string;
  icon?: IconName;
  pressed?: boolean;
}

export function IconButton({ name, icon, pressed, children, ...props }: IconButtonProps) {
  return (
    <Button
      {...props}
      class={`icon-button ${props.class ?? ""}`}
      aria-label={name}
      aria-pressed={pressed}
    >
      {icon ? <Icon name={icon} /> : children}
    </Button>
  );
}
